// SPDX-License-Identifier: MIT
//
// Needles on "gl-compute" in what batches, devices and scenes do: the same bits from every state, nothing
// paid by a scene without them, room that runs out.
#include <algorithm>
#include <limits>

#include "gl/compute/compute_device.h"
#include "support/gl_block.h"
#include "support/gl_needles.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

using GlNeedleRuns = OnCompute;

/// In and out again by half, aside and turning: `calls` calls.
template <class Step>
void drive_needle(Scene& scene, ToolPose& pose, int calls, Step&& step) {
  for (int k = 0; k < calls; ++k) {
    pose.position += Vec3(5e-5, 0, k < 8 ? -2e-3 : 1e-3);
    pose.orientation = Quaternion(Eigen::AngleAxisd(0.1 * k, Vec3::UnitZ()));
    scene.tool("needle").move_to(pose);
    step(k);
  }
}

/// From a state in the middle: in another solver, after a change of the scene, in another cut of the same steps.
TEST_F(GlNeedleRuns, GoesOnFromEveryStateWithTheSameBits) {
  for (const double stiffness : {0.0, 5e-3}) {
    BesideNeedle pair(stiffness, 3);
    drive_needle(pair.scene, pair.pose, 5, [&](int) { ASSERT_TRUE(pair.device->step(20, pair.dt).ok()); });
    const State middle = pair.device->read();
    ASSERT_TRUE(middle.tools[0].needle.punctured);
    const VecList shaft = pair.device->needle_points("needle", 4);
    const auto other = pair.make();
    other->reset(middle);
    EXPECT_EQ(other->read().tools, middle.tools);
    EXPECT_EQ(other->needle_points("needle", 4), shaft);
    pair.pose.position.z() -= 0.015;
    pair.scene.tool("needle").move_to(pair.pose);
    for (gl::DeviceSolver* solver : {pair.device.get(), other.get()}) ASSERT_TRUE(solver->step(60, pair.dt).ok());
    EXPECT_GT(other->read().tools[0].needle.hole.size(), middle.tools[0].needle.hole.size());  // of one host alone
    pair.scene.gravity({1, 0, 0});  // rows of the scene are made anew, with the hole as it is
    pair.pose.velocity = {0.01, 0, -0.1};
    pair.scene.tool("needle").move_to(pair.pose);
    ASSERT_TRUE(all_step(1, pair.dt, pair.device, other));
    ASSERT_TRUE(pair.device->step(80, pair.dt).ok());
    for (int k = 0; k < 8; ++k) ASSERT_TRUE(other->step(10, pair.dt).ok());
    const State a = pair.device->read(), b = other->read();
    EXPECT_EQ(difference(a, b), "");
    EXPECT_EQ(a.tools, b.tools);
    EXPECT_NE(a.tools[0].needle, middle.tools[0].needle);
    pair.device->request_read();
    ASSERT_TRUE(pair.device->step(20, pair.dt).ok());
    State copy;
    while (!pair.device->collect(copy)) {
    }
    EXPECT_EQ(copy, a);
    pair.device->context()->mark_lost();
    EXPECT_EQ(pair.device->step(5, pair.dt).status, StepStatus::device_lost);
    EXPECT_EQ(pair.device->read(), a);
  }
}

/// A batch that ends before its last step is done again up to there, from the hole as it was before.
TEST_F(GlNeedleRuns, BatchesDoneAgainComeToTheSame) {
  SolverOptions options = damped(200.0);
  options.rest_tolerance = 1e-4;
  BesideNeedle resting(5e-3, 3, {0, 0, 0}, options);
  const auto same = resting.make();
  resting.pose.position.z() -= 0.013;
  resting.scene.tool("needle").move_to(resting.pose);
  const RestResult rest = resting.device->run_to_rest(5000, resting.dt);
  ASSERT_TRUE(rest.converged()) << rest.message();
  ASSERT_TRUE(same->step(1, resting.dt).ok());  // in which run_to_rest() goes all the way
  ASSERT_TRUE(same->step(rest.report.steps - 1, resting.dt).ok());
  EXPECT_EQ(difference(same->read(), resting.device->read()), "");
  EXPECT_EQ(same->read().tools, resting.device->read().tools);
  EXPECT_EQ(same->tool_force("needle").force, resting.device->tool_force("needle").force);
  EXPECT_TRUE(same->read().tools[0].needle.punctured);

  SolverOptions beyond = damped(0.0);
  beyond.on_unstable = UnstableStep::allow;
  BesideNeedle failing(5e-3, 3, {0, 0, 0}, beyond);
  failing.pose.velocity = {0, 0, -0.3};
  failing.scene.tool("needle").teleport(failing.pose);
  const StepReport failed = failing.device->step(250, 6.0 * failing.dt);
  ASSERT_EQ(failed.status, StepStatus::not_finite) << failed.message();
  ASSERT_GT(failed.steps, 3);
  const State kept = failing.device->read();
  failing.device->reset();
  failing.scene.tool("needle").teleport(failing.pose);
  ASSERT_TRUE(failing.device->step(failed.steps, 6.0 * failing.dt).ok());
  EXPECT_EQ(difference(failing.device->read(), kept), "");
  EXPECT_EQ(failing.device->read().tools, kept.tools);
}

/// A needle that is put 3 cm deep at once, and a device of its own for five steps of it.
class GlComputeNeedle : public OnCompute {
 protected:
  void set_up() override {
    tables_ = tables_of(model_, {});
    const Tool needle{.shape = thin_needle(), .pose = {.position = {0.0203, 0.0197, block_side - 0.03}}};
    scene_.fix("z0").add_tool("needle", needle);
    SolverOptions options = damped(40.0);
    options.spectrum = estimate_spectrum(*tables_, tables_->rest);
    dt_ = 0.4 * stable_step(*options.spectrum, 1.0);
    solver_ = std::make_unique<gl::DeviceSolver>(GlBackend::compute, tables_, scene_, options);
  }

  /// `run` takes the device through the five steps.
  template <class Run>
  State end_of(gl::Device& device, FloatTools& tools, Run&& run) {
    State end = rest_state(model_);
    device.write(tables_->rest, end);
    begin_batch(device, tools, 5, dt_);
    run();
    device.read(tables_->rest, end);
    device.read_needles(tools);
    tools.read(end);
    return end;
  }

  Model model_ = Insertion::gel(4);
  Scene scene_{model_};
  std::shared_ptr<const TopologyTextures> tables_;
  std::unique_ptr<gl::DeviceSolver> solver_;
  double dt_ = 0.0;
};

/// Nodes that one dispatch does not get done the next ones do.
TEST_F(GlComputeNeedle, WhatOneDispatchLeavesTheNextOnesDo) {
  const SliceTables slices = pack_slices(pack_floats(*tables_), *tables_);
  const FloatNeedles packed(scene_);
  const gl::ShaderLibrary library("", solver_->context()->info().es);
  std::vector<State> ends;
  std::vector<int> dispatches;
  solver_->context()->run([&] {
    // The last one: a GPU's group, which has other sums over lanes.
    for (const std::int64_t turns :
         {std::int64_t{65535}, std::int64_t{5000}, std::numeric_limits<std::int64_t>::max()}) {
      gl::ComputeLimits limits = gl::ComputeLimits::of_context();
      limits.loop_turns = turns;
      FloatTools moved = tools_of(scene_);
      gl::ComputeDevice device(slices, scene_, moved, library, limits);
      const gl::ComputeTables constants(slices, limits);
      dispatches.push_back(gl::ComputeNeedles(packed, moved, constants, limits).follow_dispatches());
      ends.push_back(end_of(device, moved, [&] {
        device.run(5);
        EXPECT_EQ(device.report().full_step, 0);
      }));
    }
  });
  EXPECT_GT(dispatches[1], 3 * dispatches[0]);
  EXPECT_EQ(ends[0].tools.at(0).needle.hole.size(), 4u);
  EXPECT_EQ(difference(ends[0], ends[1]), "");
  EXPECT_EQ(ends[0].tools, ends[1].tools);
  EXPECT_EQ(dispatches[2], 1);
  EXPECT_LE(largest_distance(ends[0].position, ends[2].position), 1e-8);
  expect_like(ends[0].tools[0].needle, ends[2].tools[0].needle);
}

TEST_F(GlNeedleRuns, ASceneWithoutNeedlesPaysNothing) {
  const Model model = Insertion::gel(3);
  Scene with(model), without(model), alone(model);
  const Tool ball{.shape = Sphere{0.005}, .pose = {.position = {0.01, 0.01, block_side + 0.004}}};
  for (Scene* scene : {&with, &without}) scene->fix("z0").add_tool("ball", ball);
  alone.fix("z0");
  const Tool needle{.shape = thin_needle(), .pose = {.position = {0.0203, 0.0197, block_side + offset}}};
  with.add_tool("needle", needle);
  alone.add_tool("needle", needle);
  SolverOptions options = damped(5.0);
  options.profile = true;
  const auto beside = [&](const Scene& scene) { return BesideReference(model, scene, options); };
  const BesideReference plain = beside(without), both = beside(with), one = beside(alone);
  const auto runs = [&](const BesideReference& pair, const char* name) {
    const auto all = runs_of(*pair.device);
    const auto found =
        std::ranges::find(all, std::string(name) + "_kernel", &std::pair<std::string, std::int64_t>::first);
    return found == all.end() ? -1 : found->second;
  };
  for (const BesideReference* pair : {&plain, &both, &one}) ASSERT_TRUE(pair->device->step(8, plain.dt).ok());
  for (const auto& [name, count] : runs_of(*plain.device)) {
    EXPECT_EQ(name.find("needle"), std::string::npos) << name;
    EXPECT_NE(name, "press_kernel");
    EXPECT_NE(name, "free_kernel");
  }
  for (const BesideReference* pair : {&both, &one}) {
    EXPECT_EQ(runs(*pair, "free"), 8);
    EXPECT_EQ(runs(*pair, "needle_force"), 8);
    EXPECT_GE(runs(*pair, "needle_follow"), 8);
  }
  EXPECT_EQ(runs(both, "press"), 8);
  EXPECT_EQ(runs(one, "press"), -1);
  EXPECT_EQ(runs(one, "contact_grid"), -1);
  // A needle that touches nothing changes no bit; one that went leaves no pass.
  EXPECT_EQ(both.device->read().position, plain.device->read().position);
  with.remove_tool("needle");
  expect_alike(*both.device, *plain.device, plain.dt);
}

/// A shaft of 2 mm that is driven 4 cm deep has more nodes than a hole of its length.
TEST_F(GlNeedleRuns, AHoleThatIsTooLongIsReportedAndTheStateBeforeKept) {
  const Model model = Insertion::gel(4);
  Needle shape = thin_needle();
  shape.length = 0.002;
  shape.spread = 0.0025;
  Scene scene(model);
  const ToolPose start{.position = {0.0203, 0.0197, block_side + offset}, .velocity = {0, 0, -0.5}};
  scene.fix("z0").add_tool("other", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}}});
  scene.add_tool("needle", {.shape = shape, .pose = start});
  BesideReference pair(model, scene, damped(40.0));
  StepReport report;
  int steps = 0;
  for (int k = 0; k < 20 && report.ok(); ++k) {
    report = pair.device->step(50, pair.dt);
    steps += report.steps;
  }
  ASSERT_EQ(report.status, StepStatus::needle_full) << report.message();
  EXPECT_TRUE(says(report.message(), "larger Needle::spread"));
  const State kept = pair.device->read();
  EXPECT_NEAR(kept.time, steps * pair.dt, 1e-9);
  ASSERT_EQ(kept.tools[1].needle.hole.size(), 10u);
  EXPECT_EQ(pair.device->step(1, pair.dt).status, StepStatus::needle_full);
  EXPECT_EQ(pair.device->read(), kept);
  pair.device->reset();
  ASSERT_TRUE(pair.device->step(steps, pair.dt).ok());
  EXPECT_EQ(difference(pair.device->read(), kept), "");
  State longer = kept;
  longer.tools[1].needle.hole.push_back(longer.tools[1].needle.hole.back());
  EXPECT_TRUE(refuses([&] { pair.device->reset(longer); }, "hole of at most 10 points"));
  EXPECT_EQ(difference(pair.device->read(), kept), "");
}

}  // namespace
}  // namespace phymul::test
