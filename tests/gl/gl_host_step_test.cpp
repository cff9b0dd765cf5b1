// SPDX-License-Identifier: MIT
//
// Steps of the GL backends in which needles, tools on surfaces and what acts beside them act on the host: against the
// double reference, what they read of the device, and what becomes of tools that act elsewhere from a step on. The laws
// themselves: tests/interaction, on every backend.
#include <algorithm>
#include <array>

#include "support/gl_bodies.h"
#include "support/needle_insertion.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

class GlHostStep : public GlBlockTest {
 protected:
  /// How often a pass ran since the profile was cleared; 0: never.
  static std::int64_t runs(Solver& solver, const std::string& name) {
    const std::string pass = name + (GetParam() == GlBackend::fragment ? "_pass" : "_kernel");
    const auto all = runs_of(solver);
    const auto found = std::ranges::find(all, pass, &std::pair<std::string, std::int64_t>::first);
    return found == all.end() ? 0 : found->second;
  }
};

PHYMUL_ON_BOTH_DEVICES(GlHostStep);

/// m. No step ends with a tip on the surface, where rounding decides in which one the hole begins.
constexpr double over_skin = offset + 2.3e-5;

void expect_like(const NeedleState& a, const NeedleState& b) {
  EXPECT_EQ(a.punctured, b.punctured);
  EXPECT_EQ(a.through, b.through);
  EXPECT_NEAR(a.slip, b.slip, 1e-6);
  ASSERT_EQ(a.hole.size(), b.hole.size());
  for (std::size_t k = 0; k < a.hole.size(); ++k) EXPECT_EQ(a.hole[k].particles, b.hole[k].particles) << k;
  EXPECT_EQ(a.shaft.size(), b.shaft.size());
}

/// Rise, puncture, plateau and withdrawal; turning, bending, out on the far side; also 1.4 km from the origin. Bounds:
/// some ten times of what llvmpipe gave.
TEST_P(GlHostStep, WholeInsertionsAgreeWithTheReference) {
  struct Course {
    const char* name;
    double stiffness;
    Vec3 origin;
    double depth, turn, aside;
  };
  const Vec3 far(800, -600, 1000);
  for (const Course& course :
       {Course{"stiff", 0.0, {0, 0, 0}, 0.02, 0.0, 0.0}, Course{"through, bending", 2e-2, far, 0.06, 0.2, 1e-4}}) {
    SCOPED_TRACE(course.name);
    const Model model = moved(Insertion::gel(4), course.origin);
    ToolPose pose{.position = course.origin + Vec3(0.0203, 0.0197, block_side + over_skin)};
    Scene scene = Scene(model).fix("z0");
    scene.add_tool("needle", {.shape = bending(course.stiffness), .pose = pose, .friction = 0.5});
    BesideReference pair(model, scene, damped(40.0), GetParam());
    double off = 0.0, off_force = 0.0, peak = 0.0, least = 0.0;
    bool through = false;
    constexpr int parts = 8;
    for (int k = 1; k <= 2 * parts; ++k) {
      pose.position.z() -= (k <= parts ? 1.0 : -1.0) * (course.depth + offset) / parts;
      pose.position.x() += k > parts / 2 ? course.aside : 0.0;
      pose.orientation = Quaternion(Eigen::AngleAxisd(course.turn * k, Vec3::UnitZ()));
      scene.tool("needle").move_to(pose);
      const int steps = std::max(1, static_cast<int>((course.depth + offset) / parts / 0.2 / pair.dt));
      ASSERT_TRUE(all_step(steps, pair.dt, pair.device, pair.reference));
      const State a = pair.device->read(), b = pair.reference->read();
      off = std::max(off, largest_distance(a.position, b.position));
      const ToolForce fa = pair.device->tool_force("needle"), fb = pair.reference->tool_force("needle");
      off_force = std::max(off_force, (fa.mean_force - fb.mean_force).norm());
      peak = std::max(peak, fb.mean_force.norm());
      least = std::min(least, fb.mean_force.z());
      expect_like(a.tools.at(0).needle, b.tools.at(0).needle);
      through = through || a.tools[0].needle.through;
    }
    EXPECT_EQ(through, course.depth > block_side);
    EXPECT_GT(peak, 0.3);
    EXPECT_LT(least, -0.05);
    std::printf("[ HOST     ] %s: off by at most %.2g m, forces by %.2g of the peak\n", course.name, off,
                off_force / peak);
    EXPECT_LE(off, 1e-8);
    EXPECT_LE(off_force, 2e-6 * peak);
  }
}

/// A needle, a ball on triangles, one on particles, a jaw that holds some of what is around the needle, imposed
/// coordinates, a spring from a tool, a kept volume and a body below that is touched.
TEST_P(GlHostStep, EverythingActsInTheOrderOfTheReference) {
  const Model upper = moved(Insertion::gel(4), {0, 0, 0.0004}),
              lower = moved(with_material(make_block({0.05, 0.05, 0.02}, 3, 3, 2)), {-0.004, -0.006, -0.02});
  const Model model = merged({{"upper", &upper}, {"lower", &lower}});
  const double top = block_side + 0.0004;
  Scene scene = Scene(model).fix("lower/z0").gravity({0, 0, -3}).contacts({.friction = 0.3});
  scene.constrain_volume("upper");
  const Tool ball{.shape = Sphere{0.008}, .friction = 0.3};
  const auto add = [&](const char* name, Tool tool, const Vec3& position) {
    tool.pose.position = position;
    scene.add_tool(name, tool);
  };
  add("plain", ball, {0.03, 0.01, top + 0.0085});
  add("needle", {.shape = thin_needle(), .friction = 0.5}, {0.0203, 0.0197, top + over_skin});
  add("jaw", {.shape = Box{{0.012, 0.004, 0.012}}}, {0.02, 0.0442, 0.02});
  Tool on_triangles = ball;
  on_triangles.contact = ToolContact::surface;
  add("surface", on_triangles, {0.03, 0.03, top + 0.0082});
  scene.add_joint({at_tool("jaw", {0, 0, 0}), at_particle(3)}, 5.0);
  BesideReference pair(model, scene, damped(40.0), GetParam());
  double worst = 0.0;
  std::array<double, 4> largest{};
  const std::array names{"plain", "needle", "jaw", "surface"};
  for (int k = 1; k <= (sanitized ? 4 : 16); ++k) {
    scene.tool("needle").move_to({.position = {0.0203, 0.0197, top + over_skin - 1e-3 * k}});
    scene.tool("plain").move_to({.position = {0.03, 0.01 - 5e-5 * k, top + 0.0085 - 1.5e-4 * k}});
    scene.tool("surface").move_to({.position = {0.03, 0.03 + 5e-5 * k, top + 0.0082 - 1.5e-4 * k}});
    if (k == 8) scene.tool("jaw").grasp(0.0145);  // nodes of the hole among them
    if (k >= 8) scene.tool("jaw").move_to({.position = {0.02 + 1e-4 * (k - 8), 0.0442, 0.02}});
    const double off = pair.off_after(12);
    if (k > 1) worst = std::max(worst, off);
    for (std::size_t t = 0; t < names.size(); ++t) {
      const ToolForce a = pair.device->tool_force(names[t]), b = pair.reference->tool_force(names[t]);
      EXPECT_LE((a.mean_force - b.mean_force).norm(), 1e-3 * b.mean_force.norm() + 1e-4) << names[t] << k;
      largest[t] = std::max(largest[t], b.mean_force.norm());
    }
  }
  for (std::size_t t = 0; t < names.size() && !sanitized; ++t) EXPECT_GT(largest[t], 0.01) << names[t];
  std::printf("[ HOST     ] everything at once: off by %.2g of the motion\n", worst);
  EXPECT_LE(worst, 4e-6);
}

/// m, of a ball of 5 mm whose lowest point is so far above the block; negative: inside.
ToolPose above_block(double by) {
  return {.position = {0.014, 0.011, 0.025 + by}};
}

/// While nothing is in reach no step is opened for the host and nothing is gathered; then only what is near, once a
/// step.
TEST_P(GlHostStep, ReadsWhatIsWithinReach) {
  options_.profile = true;
  Scene scene = Scene(model_).fix("z0").gravity({0, 0, -2});
  scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = above_block(0.5), .contact = ToolContact::surface});
  const auto device = make(scene);
  ASSERT_TRUE(device->step(10, dt_).ok());
  device->clear_profile();
  ASSERT_TRUE(device->step(600, dt_).ok());
  EXPECT_LE(runs(*device, "gather"), 600 / 40) << "all places, now and then";
  scene.tool("ball").teleport(above_block(-5e-4));
  ASSERT_TRUE(device->step(40, dt_).ok());
  EXPECT_GT(device->tool_force("ball").force.norm(), 0.0);
  device->clear_profile();
  ASSERT_TRUE(device->step(40, dt_).ok());
  EXPECT_GE(runs(*device, "gather"), 40);
  EXPECT_LE(runs(*device, "gather"), 50);
}

/// Steps out of reach are those of the body alone, bit for bit; a body that is too fast for what was assumed
/// of it is looked at again.
TEST_P(GlHostStep, OutOfReachNothingChanges) {
  Scene alone = Scene(model_).fix("z0").gravity({0, 0, -9.81}), beside = alone.copy();
  beside.add_tool("ball", {.shape = Sphere{0.005}, .pose = above_block(0.02), .contact = ToolContact::surface});
  const auto with = make(beside), without = make(alone);
  State thrown = rest_state(model_);
  for (const Index i : model_.group("z1")) thrown.velocity[i] = {0.2, 0, 0};
  for (int k = 0; k < 3; ++k) {
    if (k == 1) with->reset(thrown), without->reset(thrown);
    if (k == 2) alone.gravity({30, 0, 0}), beside.gravity({30, 0, 0});
    ASSERT_TRUE(all_step(200, dt_, *with, *without));
    EXPECT_EQ(with->read().position, without->read().position);
    EXPECT_EQ(with->read().velocity, without->read().velocity);
  }
}

/// A tool that waits is met by a body that comes, also by one that was slow when it was last looked at; and a tool that
/// comes from afar meets the body.
TEST_P(GlHostStep, WhatComesIsMet) {
  for (const char* what : {"thrown", "accelerated", "tool"}) {
    SCOPED_TRACE(what);
    const bool thrown = what == std::string("thrown"), tool = what == std::string("tool");
    Scene scene(model_);
    scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = above_block(0.009), .contact = ToolContact::surface});
    if (tool) scene.fix("z0").tool("ball").teleport(above_block(0.02));
    BesideReference pair(model_, scene, damped(0.0), GetParam());
    State start = rest_state(model_);
    for (Vec3& v : start.velocity) v = {0, 0, thrown ? 0.6 : 0.0};
    pair.device->reset(start);
    pair.reference->reset(start);
    if (tool) {
      ToolPose moving = above_block(0.02);
      moving.velocity = {0, 0, -0.8};
      scene.tool("ball").move_to(moving);
    }
    if (!thrown && !tool) {
      ASSERT_TRUE(all_step(2, pair.dt, pair.device, pair.reference));
      scene.gravity({0, 0, 50});
    }
    double force = 0.0;  // N. Later the body crumples, and rounding decides how.
    for (int k = 0; k < 40 && force < 0.05; ++k) {
      ASSERT_TRUE(all_step(k == 0 ? 150 : 12, pair.dt, pair.device, pair.reference));
      EXPECT_LE(largest_distance(pair.device->read().position, pair.reference->read().position), 5e-7) << k;
      const ToolForce own = pair.device->tool_force("ball"), exact = pair.reference->tool_force("ball");
      EXPECT_NEAR(own.mean_force.norm(), exact.mean_force.norm(), 1e-4 * exact.mean_force.norm()) << k;
      EXPECT_EQ(pair.device->tool_pose("ball"), pair.reference->tool_pose("ball"));
      force = std::max(force, exact.mean_force.norm());
    }
    EXPECT_GE(force, 0.05);
  }
}

/// Forces that the limit of the displacement withholds are borne by what pushes against them.
TEST_P(GlHostStep, WithheldForcesAreBorne) {
  options_.max_displacement_per_step = 1e-4;
  Scene scene = Scene(model_).fix("z0");
  scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = above_block(1e-4), .contact = ToolContact::surface});
  const auto device = make(scene);
  const auto reference = make_solver("reference", tables_, scene, options_);
  scene.tool("ball").move_to(above_block(-3e-3));
  bool clamped = false;
  for (int k = 0; k < 5; ++k) {
    const StepReport report = reference->step(20, dt_);
    clamped = clamped || report.force_clamped;
    ASSERT_TRUE(report.ok() && device->step(20, dt_).ok());
    const Vec3 own = device->tool_force("ball").mean_force, exact = reference->tool_force("ball").mean_force;
    EXPECT_LE((own - exact).norm(), 1e-4 * exact.norm() + 1e-6) << k;
  }
  EXPECT_TRUE(clamped) << "or this shows nothing";
}

TEST_P(GlHostStep, NothingPullsANeedleThatWasLetGo) {
  Scene scene = Scene(model_).fix("z0");
  const ToolPose beside{.position = {0.0251, 0.0049, 0.0306}};
  scene.add_tool("needle", {.shape = thin_needle(), .pose = beside});
  scene.add_joint("thread", {.springs = {{at_mean(model_.group("z1")), at_tool("needle"), 0.0}}, .stiffness = 2.0});
  BesideReference pair(model_, scene, damped(40.0), GetParam());
  for (int k = 0; k < 3; ++k) {
    if (k == 1) scene.tool("needle").release();
    if (k == 2) scene.tool("needle").move_to(beside);
    EXPECT_LE(pair.off_after(10), 2e-5) << k;
    const double pull = pair.device->joint_report("thread").force.norm();
    EXPECT_NEAR(pull, pair.reference->joint_report("thread").force.norm(), 1e-6) << k;
    EXPECT_EQ(pull == 0.0, k == 1);
    EXPECT_EQ(pair.device->tool_force("needle").force.norm() == 0.0, k == 1);
  }
}

/// A jaw keeps what it holds when a needle comes, so that both act on the host, and when the needle goes.
TEST_P(GlHostStep, AToolGoesOnWhereItActsElsewhere) {
  Scene scene = Scene(model_).fix("z0");
  const ToolPose at{.position = {0.015, 0.01, 0.021}};
  scene.add_tool("jaw", {.shape = Box{{0.006, 0.006, 0.0015}}, .pose = at});
  BesideReference pair(model_, scene, damped(40.0), GetParam());
  scene.tool("jaw").grasp(1e-3);
  ToolPose pose = at;
  for (int k = 0; k < 12; ++k) {
    if (k == 4) scene.add_tool("needle", {.shape = thin_needle(), .pose = {.position = {0.0251, 0.0049, 0.0206}}});
    if (k == 8) scene.remove_tool("needle");
    pose.position.z() += 1e-4;
    scene.tool("jaw").move_to(pose);
    EXPECT_LE(pair.off_after(15), 2e-5) << k;
    const State a = pair.device->read(), b = pair.reference->read();
    EXPECT_EQ(a.tools.at(0).held, b.tools.at(0).held) << k;
    EXPECT_GE(a.tools[0].held.size(), 4u);
    EXPECT_EQ(pair.device->tool_pose("jaw"), pair.reference->tool_pose("jaw"));
  }
  scene.add_tool("needle", {.shape = thin_needle(), .pose = {.position = {0.0251, 0.0049, 0.0206}}});
  ASSERT_TRUE(all_step(1, pair.dt, pair.device, pair.reference));
  for (Solver* const solver : {static_cast<Solver*>(pair.device.get()), pair.reference.get()}) {
    solver->reset();
    EXPECT_EQ(solver->tool_pose("jaw").position, pose.position);
    ASSERT_TRUE(solver->step(1, pair.dt).ok());
    EXPECT_TRUE(solver->read().tools.at(0).held.empty());
  }
}

TEST_P(GlHostStep, SnapshotsCopiesAndLostDevicesGoOn) {
  Scene scene = Scene(model_).fix("z0");
  scene.add_tool(
      "ball", {.shape = Sphere{0.005}, .pose = above_block(-2e-4), .friction = 0.3, .contact = ToolContact::surface});
  const auto device = make(scene), other = make(scene);
  scene.tool("ball").move_to({.position = {0.015, 0.011, 0.0235}});
  ASSERT_TRUE(device->step(30, dt_).ok());
  const Snapshot middle = device->snapshot();
  ASSERT_TRUE(device->step(40, dt_).ok());
  const Snapshot end = device->snapshot();
  const ToolForce force = device->tool_force("ball");
  EXPECT_GT(force.force.norm(), 0.01);
  for (gl::DeviceSolver* const solver : {device.get(), other.get()}) {
    solver->restore(middle);
    ASSERT_TRUE(solver->step(40, dt_).ok());
    EXPECT_EQ(solver->snapshot(), end);
    EXPECT_EQ(solver->tool_force("ball").force, force.force);
  }
  copy_and_lose(*device, *other);
}

TEST_P(GlHostStep, RestsWhereTheReferenceDoesAndKeepsTheStateBeforeAFailure) {
  options_.damping.rate = 200.0;
  options_.rest_tolerance = 1e-4;
  Scene scene = Scene(model_).fix("z0");
  scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = above_block(-1e-4), .contact = ToolContact::surface});
  const auto device = make(scene);
  const auto reference = make_solver("reference", tables_, scene, options_);
  scene.tool("ball").move_to(above_block(-8e-4));
  for (Solver* const solver : {static_cast<Solver*>(device.get()), reference.get()}) {
    EXPECT_TRUE(solver->run_to_rest(20000, dt_).converged());
  }
  const Vec3 own = device->tool_force("ball").force, exact = reference->tool_force("ball").force;
  EXPECT_GT(exact.norm(), 1e-3);
  EXPECT_LE((own - exact).norm(), 1e-3 * exact.norm());

  scene.tool("ball").teleport(above_block(-8e-4));  // where reset() has it
  options_.on_unstable = UnstableStep::allow;
  options_.damping.rate = 0.0;
  const auto failing = make(scene);
  const StepReport failed = failing->step(2000, 12.0 * dt_);
  ASSERT_EQ(failed.status, StepStatus::not_finite) << failed.message();
  const State kept = failing->read();
  failing->reset();
  ASSERT_TRUE(failed.steps == 0 || failing->step(failed.steps, 12.0 * dt_).ok());
  EXPECT_EQ(difference(failing->read(), kept), "");
}

TEST_P(GlHostStep, ScenesWithoutSuchToolsPayNothing) {
  options_.profile = true;
  Scene scene(model_);
  scene.fix("z0").add_tool("plain", {.shape = Sphere{0.005}, .pose = {.position = {0.01, 0.01, 0.0248}}});
  const auto device = make(scene);
  const auto passes = [&] {
    device->clear_profile();
    EXPECT_TRUE(device->step(10, dt_).ok());
    return passes_run(*device, 10);
  };
  const auto without = passes();
  EXPECT_EQ(std::ranges::count_if(without, [](const std::string& name) { return name.starts_with("free"); }), 0);
  scene.add_tool("ball",
                 {.shape = Sphere{0.005}, .pose = {.position = {0.02, 0.01, 0.0248}}, .contact = ToolContact::surface});
  passes();
  EXPECT_EQ(runs(*device, "free"), 10);
  scene.remove_tool("ball");
  EXPECT_EQ(passes(), without);
}

/// Nothing to puncture: the shaft passes between the particles.
TEST_P(GlHostStep, NoHoleInABodyWithoutASurface) {
  Model model = without_cells(Insertion::gel(3));
  model.materials.clear();
  Scene scene(model);
  ToolPose pose{.position = {0.0203, 0.0197, block_side + offset}};
  scene.add_tool("needle", {.shape = thin_needle(), .pose = pose, .friction = 0.5});
  SolverOptions options = damped(40.0);
  options.on_unstable = UnstableStep::allow;
  const auto tables =
      std::make_shared<const TopologyTextures>(build_topology(model, {.on_sparse = SparseParticle::free}));
  gl::DeviceSolver solver(GetParam(), tables, scene, options);
  pose.position.z() -= 0.01;
  scene.tool("needle").move_to(pose);
  ASSERT_TRUE(solver.step(10, 1e-4).ok());
  const State state = solver.read();
  EXPECT_TRUE(state.tools[0].needle.hole.empty());
  for (const Vec3& v : state.velocity) EXPECT_EQ(v, Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace phymul::test
