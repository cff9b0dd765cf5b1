// SPDX-License-Identifier: MIT
//
// Tools on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe), against the
// double reference within bounds, and in all that batches, reports and devices do. Contacts on the GL backends (on "gl"
// by the host) in what batches, devices and scenes do: the same bits at every run, nothing paid by a scene without
// them.
#include <algorithm>
#include <array>

#include "support/gl_bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class GlTool : public GlBlockTest {};

PHYMUL_ON_BOTH_DEVICES(GlTool);

std::vector<Tool> tools_of_each_kind() {
  std::vector<Tool> all = tools_of_each_shape();
  all.insert(all.end() - 1, {.shape = Box{{0.006, 0.004, 0.004}}, .compliance = 1e-2, .margin = 1e-3});
  return all;
}

TEST_P(GlTool, EveryShapeHasTheMirrorsBits) {
  int row = 0;
  for (Tool tool : tools_of_each_kind()) {
    SCOPED_TRACE(row++);
    tool.pose = above({0.014, 0.011, 0.03});
    Scene scene = Scene(model_).fix("z0").gravity({0, 0, -2});
    scene.add_tool("tool", tool);
    scene.add_tool("jaw", {.shape = Box{{0.03, 0.002, 0.0015}}, .pose = {.position = {0.015, 0.01, 0.021}}});
    const GlTwins twins = this->twins(scene);
    int touched = 0;
    double force = 0.0, torque = 0.0;  // N and N m, largest so far
    drive(scene.tool("tool"), Vec3::Zero(), [&](int k) {
      if (k == 2) scene.tool("jaw").grasp(1e-4);
      if (k == 6) scene.tool("jaw").move_to({.position = {0.015, 0.009, 0.0215}, .velocity = {0, 0.01, 0}});
      if (k == 15) scene.tool("jaw").release();
      ASSERT_TRUE(all_step(9, dt_, twins.gl, twins.mirror));
      twins.expect_same_bits("call " + std::to_string(k));
      const ToolForce a = twins.gl->tool_force("tool"), b = twins.mirror->tool_force("tool");
      force = std::max({force, b.force.norm(), b.mean_force.norm()});
      // The terms of a torque that cancels: forces, 4 mm from the tool's middle.
      torque = std::max({torque, b.torque.norm(), 4e-3 * force});
      EXPECT_LE((a.force - b.force).norm(), 1e-5 * twins.scale_of(b.force.norm(), force) + 1e-9);
      EXPECT_LE((a.torque - b.torque).norm(), 1e-5 * twins.scale_of(b.torque.norm(), torque) + 1e-10);
      EXPECT_LE((a.mean_force - b.mean_force).norm(), 1e-5 * twins.scale_of(b.mean_force.norm(), force) + 1e-9);
      EXPECT_EQ(twins.gl->tool_pose("tool"), twins.mirror->tool_pose("tool"));
      EXPECT_TRUE(a.particles == b.particles || !twins.same_bits_expected()) << a.particles << ", " << b.particles;
      touched += b.particles;
      const State held = twins.gl->read();
      EXPECT_EQ(held.tools.at(1).held.empty(), k < 2 || k >= 15);
      EXPECT_GE(twins.gl->tool_force("jaw").particles, static_cast<int>(held.tools[1].held.size()));
      EXPECT_TRUE(held.tools == twins.mirror->read().tools || !twins.same_bits_expected());
    });
    EXPECT_GE(touched, 20);
  }
}

/// Of every other shape 1.4 km away. Bounds: twelve times the largest of what llvmpipe gave over all shapes, and more:
/// 6.2e-7 and 8.0e-7.
TEST_P(GlTool, AgreesWithTheReferenceAlsoFarFromTheOrigin) {
  double worst_place = 0.0, worst_force = 0.0;
  bool far = false;
  for (Tool tool : tools_of_each_kind()) {
    const Vec3 origin = far ? Vec3(800, -600, 1000) : Vec3(0, 0, 0);
    far = !far;
    const Model model = moved(model_, origin);
    const auto tables = tables_of(model, {});
    tool.pose = above(origin + Vec3(0.014, 0.011, 0.03));
    Scene scene = Scene(model).fix("z0");
    scene.add_tool("tool", tool);
    gl::DeviceSolver gl(GetParam(), tables, scene, options_);
    const auto reference = make_solver("reference", tables, scene, options_);
    double largest = 0.0, way = 0.0, off = 0.0, off_force = 0.0;
    drive(scene.tool("tool"), origin, [&](int) {
      ASSERT_TRUE(all_step(9, dt_, gl, reference));
      const State a = gl.read(), b = reference->read();
      off = std::max(off, largest_distance(a.position, b.position));
      way = std::max(way, largest_distance(b.position, model.rest));
      const Vec3 force = reference->tool_force("tool").mean_force;
      off_force = std::max(off_force, (gl.tool_force("tool").mean_force - force).norm());
      largest = std::max(largest, force.norm());
    });
    EXPECT_GT(way, 5e-4);
    worst_place = std::max(worst_place, off / way);
    worst_force = std::max(worst_force, off_force / largest);
  }
  std::printf("[  TOOLS  ] off the reference by at most %.2g of the motion, forces by %.2g of the largest\n",
              worst_place, worst_force);
  EXPECT_LE(worst_place, 1e-5);
  EXPECT_LE(worst_force, 1e-5);
}

/// A batch that ends before its last step is done again up to there, and counts once.
TEST_P(GlTool, BatchesDoneAgainCountOnce) {
  Scene scene(model_);
  scene.fix("z0").add_tool("ball", {.shape = Sphere{0.005}, .pose = {.position = {0.015, 0.01, 0.0249}}});
  options_.rest_tolerance = 1e-4;
  options_.damping.rate = 200.0;
  const GlTwins resting = twins(scene);
  scene.tool("ball").move_to({.position = {0.015, 0.01, 0.0245}});
  const RestResult a = resting.gl->run_to_rest(20000, dt_), b = resting.mirror->run_to_rest(20000, dt_);
  ASSERT_TRUE(a.converged() && b.converged());
  const auto expect_same = [](const GlTwins& twins) {
    const ToolForce x = twins.gl->tool_force("ball"), y = twins.mirror->tool_force("ball");
    EXPECT_GT(y.mean_force.norm(), 0.0);
    EXPECT_LE((x.mean_force - y.mean_force).norm(), 1e-4 * y.mean_force.norm());
    EXPECT_LE((x.force - y.force).norm(), 1e-4 * y.force.norm());
    EXPECT_EQ(x.particles, y.particles);
    EXPECT_EQ(twins.gl->tool_pose("ball"), twins.mirror->tool_pose("ball"));
  };
  if (a.report.steps == b.report.steps) expect_same(resting);
  EXPECT_NEAR(a.report.steps, b.report.steps, 0.05 * b.report.steps);

  options_.damping.rate = 0.0;
  const GlTwins failing = twins(scene);
  scene.tool("ball").move_to({.position = {0.015, 0.01, 0.024}, .velocity = {0, 0, -0.1}});
  const StepReport failed = failing.gl->step(250, 8.0 * dt_), too = failing.mirror->step(250, 8.0 * dt_);
  ASSERT_EQ(failed.status, StepStatus::not_finite);
  ASSERT_GT(failed.steps, 3);
  if (!failing.same_bits_expected()) return;
  ASSERT_EQ(failed.steps, too.steps);
  failing.expect_same_bits("after the failure");
  expect_same(failing);
}

TEST_P(GlTool, CopiesAndLostDevicesKnowWhatToolsHold) {
  Scene scene(model_);
  scene.add_tool("jaw", {.shape = Box{{0.03, 0.03, 0.001}}, .pose = {.position = {0.015, 0.01, 0.0209}}});
  scene.tool("jaw").grasp(1e-3);
  const auto solver = make(scene), untouched = make(scene);
  scene.tool("jaw").move_to({.position = {0.015, 0.01, 0.0212}, .velocity = {0.01, 0, 0.02}});
  EXPECT_EQ(copy_and_lose(*solver, *untouched).tools.at(0).held.size(), 35u);
  EXPECT_EQ(solver->read().tools, untouched->read().tools);
}

TEST_P(GlTool, ASceneWithoutToolsPaysNothing) {
  Scene without = Scene(model_).fix("z0"), with = without.copy();
  with.add_tool("ball", {.shape = Sphere{0.005}, .pose = {.position = {0.015, 0.01, 0.0245}}});
  options_.profile = true;
  const auto plain = make(without), touched = make(with);
  ASSERT_TRUE(all_step(8, dt_, plain, touched));
  const auto runs = runs_of(*plain), more = runs_of(*touched);
  EXPECT_NE(runs, more);
  for (const auto& [name, count] : runs) EXPECT_EQ(name.find("tool"), std::string::npos) << name;
  EXPECT_TRUE(std::ranges::any_of(more, [](const auto& pass) { return pass.first.starts_with("tool"); }));
  // The one whose tool went does what the other does, and gives its bits.
  with.remove_tool("ball");
  expect_alike(*touched, *plain, dt_);
}

/// In a plane nothing is pushed out of it, and a tool holds what it holds there.
TEST_P(GlTool, FlatBodiesStayInTheirPlane) {
  const Model sheet = make_strip(0.02, 0.02, 6, 6);
  const auto tables = tables_of(sheet, {});
  Scene scene(sheet);
  scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = {0.01, 0.023, 0.001}}, .friction = 0.3});
  SolverOptions options = options_;
  options.spectrum = {};
  const GlTwins twins(tables, scene, options, GetParam());
  const double dt = 0.3 * twins.gl->stable_step();
  scene.tool("ball").move_to({.position = {0.01, 0.02, 0.001}});
  for (int k = 0; k < 5; ++k) {
    if (k == 2) scene.tool("ball").grasp(1e-4);
    if (k == 3) scene.tool("ball").move_to({.position = {0.012, 0.019, 0.002}});
    ASSERT_TRUE(all_step(20, dt, twins.gl, twins.mirror));
    twins.expect_same_bits("call " + std::to_string(k));
  }
  EXPECT_GT(twins.gl->tool_force("ball").particles, 0);
  for (const Vec3& x : twins.gl->read().position) EXPECT_EQ(x.z(), 0.0);
}

class GlContactRuns : public OnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlContactRuns);

using GlComputeContacts = OnCompute;

/// Atomic counts come in any order, results do not.
TEST_P(GlContactRuns, RunsGiveTheSameBits) {
  const Model model = stacked(0.0005);
  std::vector<State> ends;
  for (const int calls : {1, 1, 6}) {
    Scene scene = Scene(model).gravity({1, 0, -9.81}).fix("low/z0").contacts({});
    const BesideReference pair(model, scene, damped(5.0), GetParam());
    for (int k = 0; k < calls; ++k) ASSERT_TRUE(pair.device->step(60 / calls, pair.dt).ok());
    ends.push_back(pair.device->read());
    ends.back().time = 0.0;
  }
  EXPECT_EQ(difference(ends[0], ends[1]), "");
  EXPECT_EQ(difference(ends[0], ends[2]), "");
}

/// A batch that ends before its last step is done again up to there.
TEST_P(GlContactRuns, BatchesDoneAgainComeToTheSame) {
  const Model model = stacked(0.0003);
  Scene scene = Scene(model).gravity({0, 0, -1}).fix("low/z0").contacts({.friction = 0.5});
  SolverOptions options = damped(100.0);
  options.rest_tolerance = 1e-3;
  const BesideReference pair(model, scene, options, GetParam());
  const RestResult rest = pair.device->run_to_rest(2000, pair.dt);
  ASSERT_TRUE(rest.converged()) << rest.message();
  const State rested = pair.device->read();
  pair.device->reset();
  ASSERT_TRUE(pair.device->step(rest.report.steps, pair.dt).ok());
  EXPECT_EQ(difference(pair.device->read(), rested), "");
  EXPECT_GT(lowest(rested, model.group("high")), 0.0095);

  Scene failing = Scene(model).gravity({0, 0, -10}).fix("low/z0").contacts({});
  SolverOptions beyond = damped(0.0);
  beyond.on_unstable = UnstableStep::allow;
  const BesideReference undamped(model, failing, beyond, GetParam());
  const StepReport failed = undamped.device->step(250, 8.0 * undamped.dt);
  ASSERT_EQ(failed.status, StepStatus::not_finite);
  ASSERT_GT(failed.steps, 3);
  const State kept = undamped.device->read();
  undamped.device->reset();
  ASSERT_TRUE(undamped.device->step(failed.steps, 8.0 * undamped.dt).ok());
  EXPECT_EQ(difference(undamped.device->read(), kept), "");
}

/// A body alone, bodies far from each other, one without a surface: as without contacts, to the last bit.
TEST_P(GlContactRuns, WhatTouchesNothingMovesAsItWould) {
  const Model particles = without_cells(make_block({0.02, 0.02, 0.02}, 4, 4, 4));
  for (const Model& model : {tissue({0, 0, 0}, {3, 2, 2}), stacked(4.0), particles}) {
    State end[2];
    for (const bool touching : {false, true}) {
      Scene scene = Scene(model).gravity({0.5, 0, 0});
      if (touching) scene.contacts({});
      const BesideReference pair(model, scene, damped(5.0), GetParam());
      pair.device->reset(random_state(model, 0.02, 0.01, 3));
      ASSERT_TRUE(pair.device->step(20, pair.dt).ok());
      end[touching] = pair.device->read();
    }
    EXPECT_EQ(difference(end[1], end[0]), "");
  }
}

TEST_P(GlContactRuns, ASceneWithoutContactsPaysNothing) {
  const Model model = stacked(0.001);
  Scene without = Scene(model).fix("low/z0"), with = without.copy().contacts({});
  SolverOptions options = damped(5.0);
  options.profile = true;
  const BesideReference plain(model, without, options, GetParam()), touching(model, with, options, GetParam());
  ASSERT_TRUE(all_step(8, plain.dt, plain.device, touching.device));
  const auto runs = runs_of(*plain.device), more = runs_of(*touching.device);
  for (const auto& [name, count] : runs) {
    EXPECT_EQ(name.find("contact"), std::string::npos) << name;
    EXPECT_EQ(name.find("free_"), std::string::npos) << name;
  }
  const bool draws = GetParam() == GlBackend::fragment;
  for (const char* pass : draws ? std::array{"free_pass", "gather_pass", "step_pass"}
                                : std::array{"free_kernel", "contact_search_kernel", "contact_part_kernel"}) {
    const auto found = std::ranges::find(more, pass, &std::pair<std::string, std::int64_t>::first);
    ASSERT_NE(found, more.end()) << pass;
    EXPECT_GE(found->second, 8) << pass;
    EXPECT_LE(found->second, draws ? 10 : 8) << pass;
  }
  // The one whose contacts went does what the other does, and gives its bits.
  with.no_contacts();
  expect_alike(*touching.device, *plain.device, plain.dt);
}

/// Bodies a kilometre apart are beyond the cells that floats tell apart.
TEST_F(GlComputeContacts, RefuseBodiesTooFarApart) {
  const Model model = stacked(1000.0);
  Scene scene = Scene(model).contacts({});
  EXPECT_TRUE(refuses([&] { make_solver("gl-compute", model, scene); }, "bring the bodies nearer to each other"));
}

}  // namespace
}  // namespace phymul::test
