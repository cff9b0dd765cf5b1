// SPDX-License-Identifier: MIT
//
// Calls of a simulation that end in an exception, and calls that are refused: what they leave behind.
#include <gtest/gtest.h>
#include <phymul/recording.h>

#include <stdexcept>

#include "session/scene_bytes.h"
#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

/// A swaying block; `tell`: SolverOptions::progress, after each step.
Simulation swaying(std::function<bool(const StepProgress&)> tell = {}, double rate = 0.0) {
  SimulationOptions options{.material = soft_tissue(), .backend = "reference", .damping = {.rate = rate}};
  options.solver.progress = std::move(tell);
  options.solver.progress_seconds = 0.0;
  Simulation sim(make_block({0.04, 0.04, 0.04}, 3, 3, 3), options);
  sim.scene().fix("z0").gravity({3, 0, -9.81});
  return sim;
}

TEST(InterruptedCalls, ARecordingHasTheStepsBeforeTheException) {
  for (const bool to_rest : {false, true}) {
    int left = 1000;
    Simulation sim = swaying([&](const StepProgress&) {
      if (--left == 0) throw std::runtime_error("of the user");
      return true;
    });
    sim.record();
    ASSERT_TRUE(sim.step(3, 1e-4).ok());
    left = 5;
    EXPECT_THROW(to_rest ? (void)sim.run_to_rest(20) : (void)sim.step(20, 1e-4), std::runtime_error);
    ASSERT_TRUE(sim.step(4, 1e-4).ok());
    Simulation other = swaying();
    other.replay(sim.recording());
    EXPECT_EQ(other.solver().read(), sim.solver().read()) << to_rest;
  }
}

TEST(InterruptedCalls, ProgressIsThatOfTheNextCall) {
  bool throws = true;
  int first = 0, of = 0;
  Simulation sim = swaying([&](const StepProgress& progress) {
    if (throws && progress.steps > 50) throw std::runtime_error("of the user");
    if (!throws && first == 0) first = progress.steps, of = progress.of;
    return true;
  });
  EXPECT_THROW(sim.run_to_rest(1000), std::runtime_error);
  throws = false;
  ASSERT_TRUE(sim.step(11, 1e-4).ok());
  EXPECT_EQ(first, 1);
  EXPECT_EQ(of, 11);
}

/// Velocities are converted by forces, which overflow.
TEST(InterruptedCalls, AStateBeyondAllNumbersChangesNothing) {
  Simulation sim = swaying();
  ASSERT_TRUE(sim.step(5, 1e-4).ok());
  const Snapshot before = sim.snapshot();
  State state = sim.state();
  for (Vec3& place : state.position) place *= 1e160;
  EXPECT_TRUE(refuses([&] { sim.set_state(state); }, "not finite"));
  EXPECT_EQ(sim.snapshot(), before);
  sim.set_state(sim.state());
  EXPECT_EQ(sim.step(1, 1e308).status, StepStatus::unstable_step);
}

TEST(InterruptedCalls, AHistoryStaysWhereANewOneIsRefused) {
  Simulation sim = swaying();
  sim.keep_history(1);
  ASSERT_TRUE(sim.step(5, 1e-4).ok());
  EXPECT_TRUE(refuses([&] { sim.keep_history(0); }, "expected a state every 1 step"));
  EXPECT_TRUE(sim.rewind(0.0));
}

TEST(InterruptedCalls, ARecordingOfOtherOptionsChangesNothing) {
  Simulation other = swaying({}, 5.0), sim = swaying();
  other.scene().gravity({0, 0, -1});
  other.remove_cells(std::vector<Index>{0});
  other.record();
  ASSERT_TRUE(other.step(3, 1e-4).ok());
  sim.record();
  ASSERT_TRUE(sim.step(3, 1e-4).ok());
  EXPECT_TRUE(refuses([&] { sim.replay(other.recording()); }, "damping.rate 5"));
  EXPECT_EQ(sim.scene().gravity(), Vec3(3, 0, -9.81));
  EXPECT_EQ(sim.scene().loads().size(), 1u);
  EXPECT_TRUE(sim.removed_cells().empty());
  EXPECT_NO_THROW((void)sim.recording());
}

/// By what only the recorded scene tells: its stable step.
TEST(InterruptedCalls, ARecordingThatIsRefusedLeavesTheSceneAsItWas) {
  Simulation other = swaying(), sim = swaying();
  other.record();
  ASSERT_TRUE(other.step(3, 1e-4).ok());
  Recording recording = other.recording();
  recording.options.stable_step *= 1.1;
  sim.scene().gravity({0, 0, -2}).contacts({.friction = 0.7}).scale_stiffness(0.8).constrain_volume();
  sim.scene().add(
      {.type = LoadType::force, .particles = sim.model().group("z1"), .events = {{0.0, 1.0}}, .direction = {1, 0, 0}});
  sim.scene().set_fluid("volume 1", {.law = FluidLaw::gas});
  sim.scene().add_tool("ball", {.shape = Sphere{0.01}, .pose = {.position = {0.02, 0.02, 0.1}}});
  ASSERT_TRUE(sim.step(3, 1e-4).ok());
  const std::string scene = scene_change_bytes(sim.scene(), {}, true);
  const Snapshot before = sim.snapshot();
  EXPECT_TRUE(refuses([&] { sim.replay(recording); }, "expected a solver with stable_step()"));
  EXPECT_TRUE(scene_change_bytes(sim.scene(), {}, true) == scene);
  EXPECT_EQ(sim.snapshot(), before);
}

TEST(InterruptedCalls, ARecordingThatIsRefusedLeavesCutsOpen) {
  const auto made = [](double rate) {
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.03}, 3, 2, 2, 0.2, 7), 60),
                   {.material = soft_tissue(), .backend = "reference", .damping = {.rate = rate}});
    sim.scene().fix("x0").gravity({3, 0, -9.81});
    return sim;
  };
  Simulation other = made(5.0), sim = made(0.0);
  other.record();
  sim.record();
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0, 0}, {1, 0.2, 0.1})));
  ASSERT_TRUE(sim.step(100, 1e-4).ok());
  const Snapshot before = sim.snapshot();
  EXPECT_TRUE(refuses([&] { sim.replay(other.recording()); }, "damping.rate 5"));
  EXPECT_EQ(sim.snapshot(), before);
  ASSERT_TRUE(sim.step(5, 1e-4).ok());
  Simulation again = made(0.0);
  again.replay(sim.recording());
  EXPECT_EQ(again.snapshot(), sim.snapshot());
}

/// A pose that was set begins a line of its own.
TEST(InterruptedCalls, AReplayEndsWithTheVelocitiesThatWereSet) {
  Simulation sim = swaying(), other = swaying();
  sim.record();
  ASSERT_TRUE(sim.step(5, 1e-4).ok());
  State state = sim.state();
  for (Vec3& velocity : state.velocity) velocity += Vec3(0.1, 0, 0);
  sim.set_state(state);
  other.replay(sim.recording());
  EXPECT_EQ(other.state().velocity, sim.state().velocity);
  for (Simulation* const one : {&sim, &other}) ASSERT_TRUE(one->step(3, 0.5e-4).ok());
  EXPECT_EQ(other.solver().read(), sim.solver().read());

  sim.set_state(state);
  sim.remove_cells(std::vector<Index>{0});
  other.replay(sim.recording());
  EXPECT_EQ(other.snapshot(), sim.snapshot());
  for (Simulation* const one : {&sim, &other}) ASSERT_TRUE(one->step(3, 0.5e-4).ok());
  EXPECT_EQ(other.solver().read(), sim.solver().read());
}

TEST(InterruptedCalls, AHistoryForgetsWhatLedElsewhere) {
  Simulation sim = swaying({}, 5.0), other = swaying({}, 5.0);
  other.record();
  ASSERT_TRUE(other.step(50, 1e-4).ok());
  sim.keep_history(1);
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(sim.step(1, 1e-4).ok());
  sim.replay(other.recording());
  EXPECT_FALSE(sim.rewind(2e-3));
  EXPECT_TRUE(sim.rewind(sim.time()));
  sim.keep_history(1000);
  ASSERT_TRUE(sim.solve_static().converged());
  const VecList rest = sim.solver().read().position;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(sim.step(1, 1e-4).ok());
  ASSERT_TRUE(sim.rewind(sim.time()));
  EXPECT_EQ(sim.solver().read().position, rest);
}

class Remainders : public OnEveryBackend {};

/// What rounding leaves of `advance(min(tick, end - time))`: no force is in it, and what is asked waits for the next
/// call.
TEST_P(Remainders, PassTimeAlone) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 3, 3, 3),
                 {.material = soft_tissue(), .backend = GetParam(), .damping = {.rate = 20.0}});
  ToolPose pose{.position = {0.021, 0.019, 0.043}};
  const ToolHandle ball =
      sim.scene().fix("z0").gravity({0, 0, -9.81}).add_tool("ball", {.shape = Sphere{0.01}, .pose = pose});
  ASSERT_TRUE(sim.advance(1e-3).ok());
  const auto press = [&] {
    pose.position.z() -= 1e-3;
    ball.move_to(pose);
  };
  press();
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(sim.advance(1e-3).ok());
  const Snapshot before = sim.snapshot();
  const ToolForce force = sim.force_on(ball);
  ASSERT_GT(force.force.z(), 0.0);
  press();
  ASSERT_TRUE(sim.advance(1e-3).ok());
  const State wanted = sim.solver().read();

  sim.restore(before);
  ball.move_to(pose);
  const StepReport report = sim.advance(2e-14);
  EXPECT_TRUE(report.ok()) << report.message();
  EXPECT_EQ(report.steps, 0);
  EXPECT_EQ(sim.time(), before.state.time + 2e-14);
  EXPECT_EQ(sim.solver().read().position, before.state.position);
  EXPECT_EQ(sim.force_on(ball), force);
  EXPECT_EQ(sim.pose_of(ball), before.tools.front().target);
  const StepReport tick = sim.advance(1e-3);
  ASSERT_TRUE(tick.ok());
  const State now = sim.solver().read();
  EXPECT_EQ(now.position, wanted.position);
  EXPECT_EQ(now.velocity, wanted.velocity);

  for (int k = 0; k < 3; ++k) EXPECT_EQ(sim.advance(2e-14).steps, 0) << "rounding may leave a further one";
  const StepReport still = sim.advance(2e-14);
  EXPECT_EQ(still.max_speed, tick.max_speed);
  EXPECT_EQ(still.residual, tick.residual);
  EXPECT_EQ(still.growth, tick.growth);
}

TEST_P(Remainders, SayWhatStillHolds) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 3, 3, 3),
                 {.material = soft_tissue(), .backend = GetParam(), .damping = {.rate = 50.0}});
  sim.scene().fix("z0");
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(sim.advance(1e-3).ok());
  ASSERT_TRUE(sim.advance(2e-14).at_rest);
  const Snapshot rests = sim.snapshot();
  sim.scene().gravity({9.81, 0, 0});
  ASSERT_TRUE(sim.advance(0.0).ok());
  EXPECT_FALSE(sim.advance(2e-14).at_rest);
  ASSERT_TRUE(sim.advance(1e-3).ok());
  const double time = sim.time();
  sim.scene().gravity({1e150, 0, 0});
  ASSERT_FALSE(sim.advance(1e-3).ok());
  sim.scene().gravity({9.81, 0, 0});
  EXPECT_EQ(sim.advance(2e-14).steps, 0) << "the last good state is that of a step";
  EXPECT_EQ(sim.time(), time + 2e-14);
  sim.restore(rests);
  EXPECT_TRUE(sim.advance(2e-14).at_rest);
}

/// Many of them add up to a time in which steps are due.
TEST_P(Remainders, AddUpToAStep) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 3, 3, 3), {.material = soft_tissue(), .backend = GetParam()});
  sim.scene().fix("z0").gravity({0, 0, -9.81});
  const double dt = sim.advance(1e-3).dt;
  Snapshot half_way;
  for (int k = 0; k < 14; ++k) {
    if (k == 6) half_way = sim.snapshot();
    EXPECT_EQ(sim.step(2, 4e-8 * dt).steps, k < 12 ? 0 : 2) << k;
  }
  sim.restore(half_way);
  for (int k = 6; k < 14; ++k) EXPECT_EQ(sim.step(2, 4e-8 * dt).steps, k < 12 ? 0 : 2) << k;
}

PHYMUL_ON_EVERY_BACKEND(Remainders);

}  // namespace
}  // namespace phymul::test
