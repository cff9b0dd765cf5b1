// SPDX-License-Identifier: MIT
//
// What comes in broken, out of order or in the middle of something: refused at the call with the state untouched, or
// without effect on the result.
#include <cmath>
#include <limits>
#include <thread>

#include <phymul/check.h>

#include "stability_fixture.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

Model tissue_block() {
  Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  set_material(model, soft_tissue());
  return model;
}

State bent(const Model& model) {
  State state = rest_state(model);
  state.position = random_positions(model, 0.05, 2);
  return state;
}

class StabilityInput : public OnBackend {};

TEST_P(StabilityInput, NumbersThatAreNoneAreRefusedAndNothingIsTouched) {
  const Model model = tissue_block();
  Scene scene(model);
  const auto solver = make(model, scene);
  solver->reset(bent(model));
  const double dt = 0.4 * solver->stable_step();
  ASSERT_TRUE(solver->step(5, dt).ok());
  const State before = solver->read();
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    State state = before;
    state.position[3].y() = bad;
    EXPECT_THROW(solver->reset(state), Error);
    state = before;
    state.velocity[3].y() = bad;
    EXPECT_THROW(solver->reset(state), Error);
    state = before;
    state.time = bad;
    EXPECT_THROW(solver->reset(state), Error);
    EXPECT_THROW(solver->start(before, bad), Error);
    Load load;
    load.particles = {0};
    load.direction = {1, 0, 0};
    load.events = {{0.0, bad}};
    EXPECT_THROW(scene.add(load), Error);
    load.events = {{bad, 1.0}};
    EXPECT_THROW(scene.add(load), Error);
    load.events = {{0.0, 1.0}};
    load.direction = {bad, 0, 0};
    EXPECT_THROW(scene.add(load), Error);
    EXPECT_THROW(scene.gravity({0, bad, 0}), Error);
    EXPECT_EQ(solver->step(1, bad).status, StepStatus::invalid_step);
  }
  EXPECT_TRUE(scene.loads().empty());
  EXPECT_EQ(solver->read(), before);
  EXPECT_TRUE(solver->step(5, dt).ok());
}

TEST_P(StabilityInput, ParametersOutOfRangeAreRefused) {
  Model model = tissue_block();
  const Scene scene(model);
  const auto refuses = [&](auto&& change) {
    SolverOptions options;
    change(options);
    EXPECT_THROW(make(model, scene, {}, options), Error);
  };
  refuses([](SolverOptions& o) { o.damping.factor = -0.1; });
  refuses([](SolverOptions& o) { o.damping.factor = 1.0000001; });
  refuses([](SolverOptions& o) { o.damping.factor = std::nan(""); });
  refuses([](SolverOptions& o) { o.damping.rate = std::numeric_limits<double>::infinity(); });
  refuses([](SolverOptions& o) { o.rest_tolerance = std::nan(""); });
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    Model broken = model;
    broken.mass[2] = bad;
    EXPECT_THROW(Scene{broken}, Error) << bad;
    broken = model;
    EXPECT_THROW(set_material(broken, {bad, 0.3, 1000}), Error) << bad;
    EXPECT_THROW(set_material(broken, {10e3, 0.3, bad}), Error) << bad;
    if (bad == 0.0) continue;  // no stiffness is a cloud
    broken.stiffness[2] = bad;
    EXPECT_THROW(Scene{broken}, Error) << bad;
  }
  EXPECT_THROW(set_material(model, {10e3, 0.5, 1000}), Error);
  // d = 0 takes all velocity: allowed, at the lower limit that goes with it.
  SolverOptions all_taken;
  all_taken.damping.factor = 0.0;
  const auto solver = make(model, scene, {}, all_taken);
  solver->reset(bent(model));
  EXPECT_TRUE(solver->step(50, 0.9 * solver->stable_step()).ok());
}

/// A failure in one solver is contained: it is told at the step, and a second solver over the same scene goes on.
TEST_P(StabilityInput, AFailureIsToldAtItsStepAndTouchesNoOther) {
  const Model model = tissue_block();
  const Scene scene(model);
  const auto failing = make(model, scene), other = make(model, scene), alone = make(model, scene);
  State state = bent(model);
  other->reset(state);
  alone->reset(state);
  state.velocity[7] = {1e9, 0, 0};
  failing->reset(state);
  const double dt = 0.4 * failing->stable_step();
  for (int k = 0; k < 10; ++k) {
    const StepReport report = failing->step(1, dt);
    EXPECT_EQ(report.status, StepStatus::not_finite);
    EXPECT_EQ(report.particle, 7);
    EXPECT_EQ(report.time, 0.0);
    ASSERT_TRUE(other->step(1, dt).ok());
    ASSERT_TRUE(alone->step(1, dt).ok());
  }
  EXPECT_EQ(other->read(), alone->read());
  EXPECT_TRUE(is_finite(failing->read()));
}

TEST_P(StabilityInput, ResetInMidRunIsAFreshRun) {
  const Model model = tissue_block();
  Scene scene(model);
  scene.fix("x0").gravity({0, 0, -9.81});
  const auto fresh = make(model, scene), used = make(model, scene);
  const double dt = 0.4 * fresh->stable_step();
  ASSERT_TRUE(used->step(37, dt).ok());
  used->reset(bent(model));
  fresh->reset(bent(model));
  ASSERT_TRUE(used->step(50, dt).ok());
  ASSERT_TRUE(fresh->step(50, dt).ok());
  EXPECT_EQ(used->read(), fresh->read());
}

TEST_P(StabilityInput, TwoSolversAtOnceAreIndependent) {
  if (GetParam().starts_with("gl")) GTEST_SKIP() << "GlEquivalence.FourSolversInFourThreads does this";
  const Model model = tissue_block();
  const Scene scene(model);
  const auto run = [&](int steps) {
    const auto solver = make(model, scene);
    solver->reset(bent(model));
    EXPECT_TRUE(solver->step(steps, 0.4 * solver->stable_step()).ok());
    return solver->read();
  };
  const State short_run = run(100), long_run = run(150);
  State first, second;
  std::thread one([&] { first = run(100); }), two([&] { second = run(150); });
  one.join();
  two.join();
  EXPECT_EQ(first, short_run);
  EXPECT_EQ(second, long_run);
}

/// A mirrored cell in a file is turned round at the check and named; the result is that of the right file, whatever the
/// cells' order.
TEST_P(StabilityInput, WindingAndOrderOfCellsDoNotMatter) {
  Model right = make_tetrahedral_block({0.03, 0.02, 0.02}, 3, 2, 2, 0.1, 5);
  Model wrong = right;
  std::swap(wrong.cells[4].particles[1], wrong.cells[4].particles[2]);
  std::swap(wrong.cells[4], wrong.cells[9]);
  wrong.components.clear();
  const std::vector<Finding> findings = check_mesh(wrong);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].flaw, Flaw::winding);
  EXPECT_EQ(findings[0].items, std::vector<Index>{9});
  EXPECT_TRUE(findings[0].mended);
  right.components.clear();
  set_material(right, soft_tissue());
  set_material(wrong, soft_tissue());
  const Scene scene(right), other_scene(wrong);
  const auto solver = make(right, scene), other = make(wrong, other_scene);
  solver->reset(bent(right));
  other->reset(bent(wrong));
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(50, dt).ok());
  ASSERT_TRUE(other->step(50, dt).ok());
  const State a = solver->read(), b = other->read();
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    EXPECT_LE((a.position[i] - b.position[i]).norm(), 1e-5 * mean_spacing(right));
  }
}

PHYMUL_ON_EVERY_BACKEND(StabilityInput);

}  // namespace
}  // namespace phymul::test
