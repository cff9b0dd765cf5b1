// SPDX-License-Identifier: MIT
//
// What tools hold: who gets a particle that two could have, and what remains of a hold where a solver is put elsewhere.
#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

/// A block on a jaw below it, which reaches the 25 particles of the lower face.
class ToolHold : public WithTools {
 protected:
  static constexpr int face = 25;
  static constexpr double near = 1e-4;  // m
  ToolHold() { scene_.add_tool("jaw", jaw_below()); }
  static Tool jaw_below() { return {.shape = Box{{0.02, 0.02, 0.001}}, .pose = {.position = {0.01, 0.01, -0.001}}}; }
  void make_here() {
    solver_ = make(model_, scene_);
    dt_ = 0.4 * solver_->stable_step();
  }
  /// By the question and by the state, which must agree.
  int held(const std::string& tool) const {
    const State state = solver_->read();
    const auto row = std::ranges::find(state.tools, tool, &ToolState::name);
    EXPECT_EQ(solver_->held(tool), row != state.tools.end() ? static_cast<int>(row->held.size()) : 0);
    return solver_->held(tool);
  }
  int held_after_a_step(const std::string& tool) {
    EXPECT_TRUE(solver_->step(1, dt_).ok());
    return held(tool);
  }

  const Model model_ = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene_{model_};
  std::unique_ptr<Solver> solver_;
  double dt_ = 0.0;
};
PHYMUL_ON_EVERY_BACKEND(ToolHold);

TEST_P(ToolHold, CanBeAskedForAtAnyTime) {
  make_here();
  const ToolHandle jaw = scene_.tool("jaw");
  EXPECT_EQ(solver_->held(jaw), 0);
  jaw.grasp(near);
  EXPECT_EQ(held("jaw"), 0) << "before the step that takes hold";
  EXPECT_EQ(held_after_a_step("jaw"), face);
  EXPECT_EQ(solver_->held(jaw), face);
  jaw.release();
  EXPECT_EQ(held("jaw"), face);
  EXPECT_EQ(held_after_a_step("jaw"), 0);
  scene_.add_tool("new", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}}});
  EXPECT_EQ(solver_->held("new"), 0);
  EXPECT_TRUE(refuses([&] { solver_->held("none"); }, "no tool \"none\""));
}

/// As asked, and not what the jaw held before as well.
TEST_P(ToolHold, IsTakenAnewAfterAReleaseInTheSameStep) {
  make_here();
  const ToolHandle jaw = scene_.tool("jaw");
  jaw.grasp(1.0);
  EXPECT_EQ(held_after_a_step("jaw"), model_.particle_count());
  jaw.release();
  jaw.grasp(near);
  EXPECT_EQ(held_after_a_step("jaw"), face);
  // Also where the step of the release fails.
  jaw.grasp(1.0);
  EXPECT_EQ(held_after_a_step("jaw"), model_.particle_count());
  jaw.release();
  scene_.add(
      {.type = LoadType::force, .particles = model_.group("z1"), .events = {{-1.0, 1e30}}, .direction = {1, 0, 0}});
  EXPECT_FALSE(solver_->step(1, dt_).ok());
  EXPECT_EQ(held("jaw"), model_.particle_count()) << "the state before it is kept";
  scene_.remove(0);
  jaw.grasp(near);
  EXPECT_EQ(held_after_a_step("jaw"), face);
}

TEST_P(ToolHold, AskedForBeforeTheSolverWasThereIsTaken) {
  scene_.tool("jaw").grasp(near);
  make_here();
  EXPECT_EQ(held_after_a_step("jaw"), face);
}

TEST_P(ToolHold, IsNothingAfterAResetUntilToldAnew) {
  make_here();
  const ToolHandle jaw = scene_.tool("jaw");
  jaw.grasp(near);
  ASSERT_EQ(held_after_a_step("jaw"), face);
  solver_->reset();
  EXPECT_EQ(held("jaw"), 0);
  EXPECT_EQ(held_after_a_step("jaw"), 0);
  jaw.grasp(near);
  EXPECT_EQ(held_after_a_step("jaw"), face);

  jaw.grasp(near);  // which no step sees
  solver_->reset(rest_state(model_));
  EXPECT_EQ(held_after_a_step("jaw"), 0);

  scene_.add_tool("second", jaw_below());  // which the solver has not seen
  scene_.tool("second").grasp(near);
  solver_->start(rest_state(model_), dt_);
  EXPECT_EQ(held_after_a_step("second"), 0);
  scene_.tool("second").grasp(near);
  EXPECT_EQ(held_after_a_step("second"), face);
}

TEST_P(ToolHold, IsThatOfTheStateGoneBackTo) {
  make_here();
  const ToolHandle jaw = scene_.tool("jaw");
  StateHistory history(1, 1 << 24);
  const auto step = [&] {
    const StepReport report = solver_->step(1, dt_);
    EXPECT_TRUE(report.ok());
    history.follow(*solver_, report);
    return report.time;
  };
  const double before = step();
  jaw.grasp(near);
  const double holding = step();
  ASSERT_EQ(held("jaw"), face);
  const Snapshot held_then = solver_->snapshot();

  ASSERT_TRUE(history.rewind(*solver_, before));  // while the scene says that it grasps
  EXPECT_EQ(held("jaw"), 0);
  EXPECT_EQ(held_after_a_step("jaw"), 0);
  jaw.grasp(near);
  EXPECT_EQ(held_after_a_step("jaw"), face);

  ASSERT_TRUE(history.rewind(*solver_, before));
  jaw.grasp(near);
  ASSERT_EQ(step(), holding);
  jaw.release();
  step();
  ASSERT_EQ(held("jaw"), 0);
  ASSERT_TRUE(history.rewind(*solver_, holding));  // while the scene says that it does not
  EXPECT_EQ(held("jaw"), face);
  EXPECT_EQ(held_after_a_step("jaw"), face);
  jaw.release();
  EXPECT_EQ(held_after_a_step("jaw"), 0);

  jaw.release();  // which no step sees
  solver_->restore(held_then);
  EXPECT_EQ(held_after_a_step("jaw"), face);
  State without = held_then.state;
  without.tools.clear();
  jaw.grasp(near);
  solver_->reset(without);
  EXPECT_EQ(held_after_a_step("jaw"), 0);
}

TEST_P(ToolHold, IsOfTheFirstListedOfTwoThatReachAParticle) {
  // Two layers of particles, the jaw's among them.
  const Tool wide{.shape = Box{{0.02, 0.02, 0.004}}, .pose = {.position = {0.01, 0.01, 0.002}}};
  scene_.add_tool("wide", wide);
  make_here();
  const ToolHandle jaw = scene_.tool("jaw"), second = scene_.tool("wide");
  second.grasp(0.0);
  jaw.grasp(near);
  EXPECT_EQ(held_after_a_step("jaw"), face);
  EXPECT_EQ(held("wide"), face);
  jaw.release();
  second.grasp(0.0);  // adds to what it holds
  EXPECT_EQ(held_after_a_step("jaw"), 0);
  EXPECT_EQ(held("wide"), 2 * face);

  scene_.remove_tool("jaw").remove_tool("wide").add_tool("wide", wide);
  scene_.add_tool("jaw", jaw_below());
  solver_->reset();
  scene_.tool("jaw").grasp(near);
  scene_.tool("wide").grasp(0.0);
  EXPECT_EQ(held_after_a_step("wide"), 2 * face);
  EXPECT_EQ(held("jaw"), 0);
}

TEST_P(ToolHold, GivesWayToWhatIsFixedBeforeAndAfterwards) {
  scene_.fix("x0");
  make_here();
  const ToolHandle jaw = scene_.tool("jaw");
  jaw.grasp(near);
  EXPECT_EQ(held_after_a_step("jaw"), face - 5) << "an edge of five is fixed";
  scene_.fix("z0");
  jaw.move_to({.position = {0.011, 0.01, -0.002}});
  EXPECT_EQ((solver_->step(10, dt_), held("jaw")), face - 5);
  const State state = solver_->read();
  for (const Index i : model_.group("z0")) EXPECT_EQ(state.position[i], model_.rest[i]) << i;
}

/// A tool whose next pose is no number ends the call, at its last pose. Nor is a place beyond single precision taken.
TEST_P(ToolHold, IsOfNoToolWithoutAPlace) {
  scene_.add_tool("spinning", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}, .spin = {1e200, 0, 0}}});
  make_here();
  const StepReport report = solver_->step(20, dt_);
  EXPECT_EQ(report.status, StepStatus::not_finite) << report.message();
  EXPECT_TRUE(solver_->tool_pose("spinning").orientation.coeffs().allFinite());
  Snapshot far = solver_->snapshot();
  if (far.displacement.empty()) return;  // a backend in double precision
  far.displacement[20].x() = 1e39;
  EXPECT_TRUE(refuses([&] { solver_->restore(far); }, "beyond single precision"));
}

class ToolHoldAndNeedle : public ToolHold {};
PHYMUL_ON_EVERY_BACKEND(ToolHoldAndNeedle);

TEST_P(ToolHoldAndNeedle, OfAnotherShapeIsRefusedAndTheSolverIsAsItWas) {
  scene_.tool("jaw").grasp(near);
  make_here();
  ASSERT_EQ(held_after_a_step("jaw"), face);
  const Snapshot holding = solver_->snapshot();
  scene_.remove_tool("jaw").add_tool("jaw", {.shape = Needle{}, .pose = {.position = {0.01, 0.01, 0.03}}});
  ASSERT_TRUE(solver_->step(1, dt_).ok());
  const Snapshot with_needle = solver_->snapshot();
  EXPECT_TRUE(
      refuses([&] { solver_->restore(holding); }, "holds 25 particles, but the scene's tool of that name is a needle"));
  EXPECT_TRUE(refuses([&] { solver_->reset(holding.state); }, "is a needle"));
  EXPECT_EQ(solver_->snapshot(), with_needle);
  EXPECT_EQ(held("jaw"), 0);
  Snapshot twice = holding;
  twice.state.tools[0].held[1] = twice.state.tools[0].held[0];
  EXPECT_TRUE(refuses([&] { solver_->restore(twice); }, "or holds a particle twice"));

  Snapshot pierced = holding;
  pierced.state.tools[0].held.clear();
  pierced.state.tools[0].held_at.clear();
  pierced.state.tools[0].needle.hole = {{.particles = {0}, .weights = {1.0}}};
  scene_.remove_tool("jaw").add_tool("jaw", jaw_below());
  EXPECT_TRUE(refuses([&] { solver_->restore(pierced); },
                      "has a needle's hole, but the scene's tool of that name is no needle"));
  solver_->restore(holding);
  EXPECT_EQ(held("jaw"), face);
}

/// What bodies gain is what the tool gives, also where another body and a fluid press on particles that it holds.
TEST(ToolHoldFeels, WhatPressesOnWhatItHolds) {
  const Model model = cubes_apart(2e-4);
  const double top = 2.0 * cubes_edge + 2e-4;
  const Scene contacts = Scene(model).contacts({.friction = 0.3}), fluid = Scene(model).constrain_volume("upper");
  for (const Scene* of : {&contacts, &fluid}) {
    for (const char* backend : {"reference", "cpu"}) {
      Scene scene = of->copy();
      ToolPose pose{.position = {0.01, 0.01, top + (of == &fluid ? 0.5 * cubes_edge : 0.0)}};
      const ToolHandle grip = scene.add_tool("grip", {.shape = Box{Vec3(0.6, 0.6, 1.005) * cubes_edge}, .pose = pose});
      grip.grasp(0.0);
      const auto solver = make_solver(backend, model, scene);
      const double dt = 0.3 * solver->stable_step();
      for (int k = 0; k < 60; ++k) {
        pose.position += Vec3(2e-6, 0, -1e-5);
        grip.move_to(pose);
        const Momentum before = solver->momentum();
        ASSERT_TRUE(solver->step(1, dt).ok());
        const Imbalance left = imbalance(before, solver->momentum(), *solver, {"grip"}, dt);
        ASSERT_LT(left.force.norm(), 1e-6) << backend << (of == &fluid);
        ASSERT_LT(left.torque.norm(), 1e-3 * cubes_edge) << "contacts act over a gap";
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test
