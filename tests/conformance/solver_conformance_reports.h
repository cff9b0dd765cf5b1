// SPDX-License-Identifier: MIT
//
// What every backend tells of its steps: energies, the rest test, failures, and the instant at which loads act.
// Included by solver_conformance.h.
#pragma once

#include <limits>

#include "solver_conformance_progress.h"
#include "support/message_of.h"

namespace phymul::test {

/// Moves the whole body: a uniform acceleration, m/s^2, or a rigid translation, m.
inline Load on_all(const Model& model, LoadType type, const Vec3& direction, std::vector<ValueEvent> events) {
  return {.type = type, .particles = every_particle(model), .events = std::move(events), .direction = direction};
}

inline State moving(const Model& model, const Vec3& velocity) {
  State state = rest_state(model);
  for (Vec3& v : state.velocity) v = velocity;
  return state;
}

TEST_P(SolverConformance, EnergyOfAFallIsThatOfTheScheme) {
  Scene scene = Scene(model_).gravity({0, 0, -9.81});
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step();
  const int steps = 50;
  const StepReport report = solver->step(steps, dt);
  ASSERT_TRUE(report.ok());
  const Energy energy = solver->energy();
  // 1/2 m v- v+ with v = n g dt before and (n + 1) g dt after; what the height n (n + 1) / 2 g dt^2 gave.
  const double expected = 0.5 * total_mass(model_) * std::pow(9.81 * dt, 2) * steps * (steps + 1);
  EXPECT_NEAR(energy.kinetic, expected, 1e-4 * expected);
  EXPECT_NEAR(energy.gravity, -expected, 1e-4 * expected);
  EXPECT_LE(energy.elastic, 1e-4 * expected);
  const double heaviest = *std::max_element(model_.mass.begin(), model_.mass.end());
  EXPECT_NEAR(report.residual, 9.81 * heaviest, 1e-4 * 9.81 * heaviest);
  EXPECT_NEAR(report.max_speed, 9.81 * dt * steps, 1e-4 * 9.81 * dt * steps);
}

TEST_P(SolverConformance, HeldParticlesHaveTheirOwnSpeedAndNoForce) {
  Scene scene(model_);
  scene.gravity({0, 0, -9.81}).add(on_all(model_, LoadType::translation, {0, 0, 1}, {{0.0, 0.0}, {1.0, 0.1}}));
  const auto solver = make(model_, scene);
  const StepReport report = solver->step(20, 0.5 * solver->stable_step());
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report.residual, 0.0);
  EXPECT_EQ(report.max_speed, 0.0);
  EXPECT_TRUE(report.at_rest);  // nothing is free to move
  const State state = solver->read();
  for (const Vec3& v : state.velocity) EXPECT_NEAR(v.z(), 0.1, 1e-4);
  const double expected = 0.5 * total_mass(model_) * 0.01;
  EXPECT_NEAR(solver->energy().kinetic, expected, 1e-3 * expected);
}

TEST_P(SolverConformance, ImposedPositionsAreThoseOfTheNewTime) {
  Scene scene = Scene(model_).add(on_all(model_, LoadType::translation, {0, 0, 1}, {{0.0, 0.0}, {1.0, 0.1}}));
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step();
  for (int step = 1; step <= 3; ++step) {
    ASSERT_TRUE(solver->step(1, dt).ok());
    const State state = solver->read();
    EXPECT_NEAR(state.position[0].z(), 0.1 * state.time, 0.02 * 0.1 * dt);
  }
}

TEST_P(SolverConformance, LoadsActFromTheInstantOfTheState) {
  Scene scene = Scene(model_).add(on_all(model_, LoadType::acceleration, {0, 0, -1}, {{1.0, 9.81}, {1.5, 0.0}}));
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step(), gained = 9.81 * dt;
  State start = rest_state(model_);
  start.time = 1.0;
  solver->reset(start);
  ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_NEAR(solver->read().velocity[0].z(), -gained, 1e-4 * gained);
  scene.replace(0, on_all(model_, LoadType::acceleration, {1, 0, 0}, {{0.5, 9.81}}));
  ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_NEAR(solver->read().velocity[0].x(), gained, 1e-4 * gained);
  scene.clear().add(on_all(model_, LoadType::acceleration, {0, 1, 0}, {{0.5, 9.81}}));
  start = rest_state(model_);
  solver->reset(start);  // the new scene at the time of the state, where its load does not act yet
  for (Vec3& p : start.position) p.y() += 0.01;
  EXPECT_EQ(solver->energy().gravity, 0.0);
  ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_NEAR(solver->read().velocity[0].y(), 0.0, 1e-4 * gained);
}

TEST_P(SolverConformance, ResetForgetsTheStepsBefore) {
  Scene scene = Scene(model_).gravity({0, 0, -9.81});
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(20, dt).ok());
  solver->reset(moving(model_, {0, 0, 0.1}));
  const double expected = 0.5 * total_mass(model_) * 0.01;
  EXPECT_NEAR(solver->energy().kinetic, expected, 1e-4 * expected);

  scene.gravity({0, 0, 0});
  solver->reset();
  EXPECT_TRUE(solver->step(20, dt).at_rest);
  EXPECT_TRUE(solver->step(1, dt).at_rest);
  solver->reset();
  EXPECT_FALSE(solver->step(1, dt).at_rest) << "one quiet step is not " << SolverOptions{}.rest_steps;
  EXPECT_TRUE(solver->step(20, dt).at_rest);
  scene.gravity({0, 0, -9.81});  // reset looks at the scene too
  State raised = rest_state(model_);
  for (Vec3& p : raised.position) p.z() += 0.01;
  solver->reset(raised);
  EXPECT_NEAR(solver->energy().gravity, total_mass(model_) * 9.81 * 0.01, 1e-4 * total_mass(model_));
  scene.clear().fix("x0");
  solver->reset();
  EXPECT_TRUE(solver->step(20, dt).at_rest);
  scene.gravity({0, 0, 0});  // a change of the scene, whatever it says, starts the count anew
  EXPECT_FALSE(solver->step(1, dt).at_rest);
}

TEST_P(SolverConformance, RestTakesSlowAndUnpushedStepsOnEnd) {
  SolverOptions options{.rest_tolerance = 1e-4, .rest_steps = 3};
  Scene empty(model_), falling(model_), later(model_);
  const auto drifting = make(model_, empty, options);
  const double dt = 0.5 * drifting->stable_step();
  drifting->reset(moving(model_, {0.1, 0, 0}));  // no force, but not slow
  EXPECT_FALSE(drifting->step(10, dt).at_rest);

  options.rest_steps = 1;
  falling.gravity({0, 0, -9.81});
  const auto turning = make(model_, falling, options);
  turning->reset(moving(model_, {0, 0, 9.81 * dt}));  // stands still after one step, but not for long
  EXPECT_FALSE(turning->step(1, dt).at_rest);

  const double push = 20.5 * dt;
  later.add(on_all(model_, LoadType::acceleration, {0, 0, -1}, {{0.0, 0.0}, {push, 0.0}, {push, 9.81}}));
  const auto pushed = make(model_, later, options);
  EXPECT_TRUE(pushed->step(20, dt).at_rest);
  EXPECT_FALSE(pushed->step(3, dt).at_rest);
}

TEST_P(SolverConformance, RunToRestStopsAtTheToleranceAsked) {
  Scene scene = Scene(model_).fix("z1").gravity({0, 0, -9.81});
  SolverOptions options{.damping = {.rate = 60.0}};
  int before = 0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    options.rest_tolerance = tolerance;
    const auto solver = make(model_, scene, options);
    const RestResult rest = solver->run_to_rest(20000, 0.5 * solver->stable_step());
    EXPECT_TRUE(rest.converged()) << tolerance;
    EXPECT_LT(rest.report.steps, 20000) << tolerance;
    EXPECT_GT(rest.report.steps, before) << tolerance;
    before = rest.report.steps;
  }
}

TEST_P(SolverConformance, FasterThanAnyWaveIsAFailureAndLeavesNoTrace) {
  Scene scene(model_);
  const auto probe = make(model_, scene);
  const double dt = 0.5 * probe->stable_step();
  // Acts on the step that fails, not at the time that is kept.
  scene.add(on_all(model_, LoadType::acceleration, {0, 0, -1}, {{0.0, 0.0}, {0.5 * dt, 0.0}, {0.5 * dt, 9.81}}));
  const auto solver = make(model_, scene);
  State start = rest_state(model_);
  for (Vec3& p : start.position) p.z() += 0.01;
  start.velocity[5] = {1e9, 0, 0};
  solver->reset(start);
  const StepReport report = solver->step(3, dt);
  EXPECT_EQ(report.status, StepStatus::not_finite);
  EXPECT_EQ(report.steps, 0);
  EXPECT_EQ(report.particle, 5);
  const State kept = solver->read();
  EXPECT_EQ(kept.time, 0.0);
  EXPECT_LE(largest_distance(kept.position, start.position), 1e-6 * body_size(model_));
  EXPECT_EQ(solver->energy().gravity, 0.0);
}

TEST_P(SolverConformance, PlaneBodiesKeepTheirPlane) {
  const Model model = make_strip(0.04, 0.02, 4, 2);
  const Scene scene(model);
  TopologyOptions springs;
  springs.law = Law::springs;
  const auto solver = make(model, scene, {}, springs);
  solver->reset(displaced(model, 0.1, 2));
  ASSERT_TRUE(solver->step(50, 0.4 * solver->stable_step()).ok());
  for (const Vec3& p : solver->read().position) EXPECT_EQ(p.z(), 0.0);
}

TEST_P(SolverConformance, ScatteredBodiesComeBackAndTheReportSaysThatForcesWereCut) {
  const Scene scene(model_);
  SolverOptions options{.damping = {.factor = 0.98}};
  const auto solver = make(model_, scene, options);
  const State scattered = displaced(model_, 1.5, 7);
  solver->reset(scattered);
  const double dt = 0.5 * solver->stable_step();
  EXPECT_TRUE(solver->step(1, dt).force_clamped);
  const StepReport report = solver->step(4000, dt);
  ASSERT_TRUE(report.ok()) << report.message();
  EXPECT_TRUE(report.force_clamped);
  EXPECT_TRUE(says(report.message(), "elastic forces were clamped"));
  EXPECT_LE(solver->energy().elastic, 1e-6 * soft_tissue().young * volume(model_, model_.rest));
  EXPECT_FALSE(solver->step(1, dt).force_clamped);

  options.max_displacement_per_step = std::numeric_limits<double>::infinity();
  const auto uncut = make(model_, scene, options);
  uncut->reset(scattered);
  EXPECT_FALSE(uncut->step(1, dt).force_clamped);
}

// A report is about the steps that were done: not the one that failed.
TEST_P(SolverConformance, CutsOfAStepThatFailedAreNotReported) {
  Scene scene(model_);
  const auto solver = make(model_, scene);
  State scattered = rest_state(model_), running = scattered;
  scattered.position = random_positions(model_, 1.5, 7);
  running.position = scattered.position;
  running.velocity[5] = {1e9, 0, 0};
  solver->reset(running);
  const double dt = 0.5 * solver->stable_step();
  const StepReport at_once = solver->step(3, dt);
  EXPECT_EQ(at_once.status, StepStatus::not_finite);
  EXPECT_EQ(at_once.steps, 0);
  EXPECT_FALSE(at_once.force_clamped);

  const double late = 4.5 * dt;
  scene.add(on_all(model_, LoadType::acceleration, {0, 0, -1}, {{0.0, 0.0}, {late, 0.0}, {late, 1e20}}));
  solver->reset(scattered);
  const StepReport report = solver->step(20, dt);
  EXPECT_EQ(report.status, StepStatus::not_finite);
  EXPECT_EQ(report.steps, 5);
  EXPECT_TRUE(report.force_clamped);
}

TEST_P(SolverConformance, CloudWithoutStiffnessFalls) {
  Model model = without_cells(model_);
  model.materials.clear();
  model.neighbours.offset.assign(model.rest.size() + 1, 0);
  model.neighbours.entry.clear();
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  const auto solver = make(model, scene, {}, {.on_sparse = SparseParticle::free});
  EXPECT_EQ(solver->stable_step(), std::numeric_limits<double>::infinity());
  ASSERT_TRUE(solver->step(10, 0.01).ok());
  EXPECT_NEAR(solver->read().velocity[3].z(), -0.981, 1e-5);
}

}  // namespace phymul::test
