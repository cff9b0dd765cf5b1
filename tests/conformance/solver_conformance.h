// SPDX-License-Identifier: MIT
//
// What every backend must do. Instantiated for each built one in solver_conformance_test.cpp; a backend built out of
// tree includes this file and instantiates it with a function that makes its solver.
#pragma once

#include <limits>

#include "solver_conformance_progress.h"
#include "solver_conformance_reports.h"
#include "support/message_of.h"

namespace phymul::test {

TEST_P(SolverConformance, RestStaysAtRest) {
  for (const Body& body : bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const auto solver = make(body.model, scene, {}, {.on_sparse = SparseParticle::springs});
    const StepReport report = solver->step(200, 0.5 * solver->stable_step());
    EXPECT_TRUE(report.ok()) << report.message();
    EXPECT_TRUE(report.at_rest);
    EXPECT_LE(largest_distance(solver->read().position, body.model.rest), 1e-9 * mean_spacing(body.model));
  }
}

TEST_P(SolverConformance, FreeFall) {
  Scene scene = Scene(model_).gravity({0, 0, -9.81});
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step();
  const int steps = 400;
  ASSERT_TRUE(solver->step(steps, dt).ok());
  const State state = solver->read();
  EXPECT_NEAR(state.time, steps * dt, 1e-9 * state.time);
  // The scheme's own closed form: v_n = n g dt, x_n = n (n + 1) / 2 g dt^2.
  const double fall = -9.81 * dt * dt * steps * (steps + 1) / 2.0;
  // Adding the same to the same binade errs the same way at every step.
  const double tolerance = std::max(1e-6, steps * roundoff());
  for (Index i = 0; i < model_.particle_count(); ++i) {
    EXPECT_NEAR(state.position[i].z() - model_.rest[i].z(), fall, tolerance * std::abs(fall));
    EXPECT_NEAR(state.velocity[i].z(), -9.81 * dt * steps, tolerance * 9.81 * dt * steps);
  }
}

TEST_P(SolverConformance, RigidMotionOfTheSceneMovesTheResult) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Vec3 shift(0.3, -0.2, 0.1), g(2.0, 1.0, -9.81);
  Model moved = model_;
  for (Vec3& p : moved.rest) p = turn * p + shift;
  Scene scene = Scene(model_).fix("x0").gravity(g), moved_scene = Scene(moved).fix("x0").gravity(turn * g);
  const auto solver = make(model_, scene), moved_solver = make(moved, moved_scene);
  ASSERT_TRUE(all_step(500, 0.4 * solver->stable_step(), solver, moved_solver));
  const State a = solver->read(), b = moved_solver->read();
  for (Index i = 0; i < model_.particle_count(); ++i) {
    EXPECT_LE((turn * a.position[i] + shift - b.position[i]).norm(),
              std::max(1e-6, 200 * roundoff()) * mean_spacing(model_))
        << i;
  }
}

TEST_P(SolverConformance, ImposedPositionsAreMetAndOtherAxesAreFree) {
  Scene scene = Scene(model_).fix("x0");
  scene.add({.type = LoadType::translation,
             .particles = model_.group("x1"),
             .events = {{0.0, 0.0}, {0.05, 0.003}},
             .axes = {Axis::driven, Axis::free, Axis::free},
             .direction = {1, 0, 0}});
  const auto solver = make(model_, scene, damped(60.0));
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(static_cast<int>(0.2 / dt), dt).ok());
  const State state = solver->read();
  for (Index i : model_.group("x0")) EXPECT_LE((state.position[i] - model_.rest[i]).norm(), 1e-9);
  bool narrowed = false;
  for (Index i : model_.group("x1")) {
    EXPECT_NEAR(state.position[i].x() - model_.rest[i].x(), 0.003, 1e-8);
    narrowed = narrowed || std::abs(state.position[i].y() - model_.rest[i].y()) > 1e-5;
  }
  EXPECT_TRUE(narrowed);
}

TEST_P(SolverConformance, HangsToRestUnderGravityAndBearsItsWeight) {
  Scene scene = Scene(model_).fix("z1").gravity({0, 0, -9.81});
  const auto solver = make(model_, scene, damped(60.0));
  const RestResult rest = solver->run_to_rest(200000, 0.5 * solver->stable_step());
  ASSERT_TRUE(rest.report.ok()) << rest.message();
  EXPECT_TRUE(rest.converged());
  const VecList force = forces_at(solver->topology(), solver->read().position);
  double held = 0.0, hanging = 0.0;
  const std::vector<Index> top = model_.group("z1");
  for (Index i = 0; i < model_.particle_count(); ++i) {
    const bool fixed = std::find(top.begin(), top.end(), i) != top.end();
    (fixed ? held : hanging) += fixed ? force[i].z() : 9.81 * model_.mass[i];
  }
  EXPECT_NEAR(-held, hanging, 1e-3 * hanging);
}

TEST_P(SolverConformance, DampingRateGivesTheSameResultAtAnyStep) {
  Scene scene = Scene(model_).fix("x0").gravity({0, 0, -9.81});
  const SolverOptions options{.damping = {.rate = 20.0}};
  const auto coarse = make(model_, scene, options), fine = make(model_, scene, options);
  const double dt = 0.4 * coarse->stable_step();
  ASSERT_TRUE(coarse->step(200, dt).ok());
  ASSERT_TRUE(fine->step(800, dt / 4).ok());
  const PositionError error = position_error(model_, coarse->read().position, fine->read().position);
  EXPECT_LE(error.global_ratio, 0.02);
}

TEST_P(SolverConformance, RenumberingPermutesTheResult) {
  const Model model = jittered_block();
  const Index n = model.particle_count();
  std::vector<Index> to(n);
  for (Index i = 0; i < n; ++i) to[i] = (i * 37 + 11) % n;
  Model shuffled = model;
  std::vector<std::vector<Index>> rows(n);
  for (Index i = 0; i < n; ++i) {
    shuffled.rest[to[i]] = model.rest[i];
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) rows[to[i]].push_back(to[*j]);
  }
  shuffled.neighbours = {};
  for (const auto& row : rows) shuffled.neighbours.push_row(row.begin(), row.end());
  for (Cell& cell : shuffled.cells) {
    for (Index& p : cell.particles) p = to[p];
  }
  shuffled.components.clear();
  const Scene scene(model), shuffled_scene(shuffled);
  const auto solver = make(model, scene), other = make(shuffled, shuffled_scene);
  State start = rest_state(model), shuffled_start = rest_state(shuffled);
  start.position = random_positions(model, 0.02, 4);
  for (Index i = 0; i < n; ++i) shuffled_start.position[to[i]] = start.position[i];
  solver->reset(start);
  other->reset(shuffled_start);
  ASSERT_TRUE(all_step(50, 0.3 * solver->stable_step(), solver, other));
  const State a = solver->read(), b = other->read();
  for (Index i = 0; i < n; ++i) {
    EXPECT_LE((a.position[i] - b.position[to[i]]).norm(), 1e-5 * mean_spacing(model));
  }
}

TEST_P(SolverConformance, StateRoundTripGoesOnAsIfNothingHappened) {
  Scene scene = Scene(model_).fix("x0").gravity({0, 0, -9.81});
  const auto straight = make(model_, scene), halved = make(model_, scene), resumed = make(model_, scene);
  const double dt = 0.5 * straight->stable_step();
  ASSERT_TRUE(straight->step(200, dt).ok());
  ASSERT_TRUE(halved->step(100, dt).ok());
  resumed->reset(halved->read());
  ASSERT_TRUE(resumed->step(100, dt).ok());
  const PositionError error = position_error(model_, resumed->read().position, straight->read().position);
  EXPECT_LE(error.global_ratio, 1e-5);
}

TEST_P(SolverConformance, StepInPiecesIsBitEqual) {
  Scene scene = Scene(model_).fix("x0").gravity({0, 0, -9.81});
  const auto once = make(model_, scene), pieces = make(model_, scene);
  const double dt = 0.5 * once->stable_step();
  ASSERT_TRUE(once->step(30, dt).ok());
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(pieces->step(3, dt).ok());
  EXPECT_EQ(once->read(), pieces->read());
}

TEST_P(SolverConformance, SceneMayChangeBetweenSteps) {
  Scene scene(model_);
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(10, dt).ok());
  scene.gravity({0, 0, -9.81}).fix("x0");
  ASSERT_TRUE(solver->step(100, dt).ok());
  const State state = solver->read();
  for (Index i : model_.group("x0")) EXPECT_LE((state.position[i] - model_.rest[i]).norm(), 1e-9);
  EXPECT_LT(state.position[model_.group("x1")[0]].z(), model_.rest[model_.group("x1")[0]].z());
  scene.clear();
  ASSERT_TRUE(solver->step(10, dt).ok());
}

TEST_P(SolverConformance, EnergyIsThatOfTheSceneAsItStands) {
  Scene scene(model_);
  const auto solver = make(model_, scene);
  State lifted = rest_state(model_);
  for (Vec3& x : lifted.position) x.z() += 0.5;
  solver->reset(lifted);
  EXPECT_EQ(solver->energy().gravity, 0.0);
  scene.gravity({0, 0, -10});
  const double mass = total_mass(model_);
  EXPECT_NEAR(solver->energy().gravity, 5.0 * mass, 1e-5 * mass);
}

TEST_P(SolverConformance, StatesOffThePlaneOfATwoDimensionalModelAreRefused) {
  const Model model = make_strip(0.04, 0.02, 4, 2, true);
  const Scene scene(model);
  const auto solver = make(model, scene);
  State state = solver->read();
  state.position[3].z() = 1e-3;
  EXPECT_THROW(solver->reset(state), Error);
  state = solver->read();
  state.velocity[3].z() = 1e-3;
  EXPECT_THROW(solver->reset(state), Error);
  EXPECT_EQ(solver->read(), rest_state(model));
}

TEST_P(SolverConformance, StepBeyondTheLimitIsRefusedAndNothingMoves) {
  Scene scene = Scene(model_).gravity({0, 0, -9.81});
  const auto solver = make(model_, scene);
  const State before = solver->read();
  const StepReport report = solver->step(10, 1.5 * solver->stable_step());
  EXPECT_EQ(report.status, StepStatus::unstable_step);
  EXPECT_EQ(report.steps, 0);
  EXPECT_EQ(solver->read(), before);
  EXPECT_TRUE(says(report.message(), "is above the stable step"));
  EXPECT_EQ(solver->step(1, 1.001 * solver->stable_step()).status, StepStatus::unstable_step);
  EXPECT_TRUE(solver->step(1, solver->stable_step()).ok());
}

/// The limit of (omega_max dt)^2 <= 2 (1 + d), where d = exp(-rate dt) falls with dt.
TEST_P(SolverConformance, ARateOfDampingLowersTheStepLimit) {
  const Scene scene(model_);
  const double free = make(model_, scene)->stable_step();
  const auto displacement_after = [&](double share) {
    const auto solver = make(model_, scene, {.damping = {.rate = 1.0 / free}, .on_unstable = UnstableStep::allow});
    const double limit = solver->stable_step();
    EXPECT_NEAR(2.0 * limit * limit, (1.0 + std::exp(-limit / free)) * free * free, 1e-12 * free * free);
    solver->reset(displaced(model_, 1e-4, 3));
    const StepReport report = solver->step(2000, share * limit);
    EXPECT_EQ(report.beyond_limit, share > 1.0);
    if (!report.ok()) return std::numeric_limits<double>::infinity();
    return largest_distance(solver->read().position, model_.rest);
  };
  EXPECT_LT(displacement_after(0.97), 1e-4 * 0.01);
  EXPECT_GT(displacement_after(1.03), 1e-2 * 0.01);
}

TEST_P(SolverConformance, InvalidStepsAreRefused) {
  const Scene scene(model_);
  const auto solver = make(model_, scene);
  const auto refused = [&](const StepReport& report, const char* why) {
    EXPECT_EQ(report.status, StepStatus::invalid_step);
    EXPECT_FALSE(report.ok());
    EXPECT_EQ(report.steps, 0);
    EXPECT_TRUE(says(report.message(), why));
  };
  for (double dt : {0.0, -1e-3, std::nan(""), -HUGE_VAL})
    refused(solver->step(1, dt), "expected a finite step above 0");
  for (double dt : {1e-320, 1e-40, 0.9e-18}) refused(solver->step(1, dt), "at least 1e-18 s");
  refused(solver->step(1, INFINITY), "stable_step() is infinite for a body without stiffness");
  refused(solver->step(-1, 1e-6), "expected 0 steps or more");
  EXPECT_TRUE(solver->step(1, 1e-18).ok());
}

TEST_P(SolverConformance, RunToRestSaysWhetherItRests) {
  Scene scene = Scene(model_).fix("z1").gravity({0, 0, -9.81});
  SolverOptions options;
  const auto undamped = make(model_, scene, options);
  const double dt = 0.5 * undamped->stable_step();
  RestResult rest = undamped->run_to_rest(200000, dt);
  EXPECT_EQ(rest.status, RestStatus::failed);
  EXPECT_EQ(rest.report.status, StepStatus::invalid_step);
  EXPECT_EQ(rest.report.steps, 0);
  EXPECT_TRUE(says(rest.message(), "expected damping"));
  EXPECT_EQ(undamped->read().time, 0.0);

  options.damping.rate = 60.0;
  const auto damped = make(model_, scene, options);
  rest = damped->run_to_rest(10, dt);
  EXPECT_TRUE(rest.report.ok());
  EXPECT_EQ(rest.status, RestStatus::step_limit);
  EXPECT_FALSE(rest.converged());
  EXPECT_EQ(rest.message().find("not at rest after 10 steps"), 0u) << rest.message();
  EXPECT_EQ(damped->step(10, dt).message().find("ok: 10 steps"), 0u);
  options.rest_tolerance = 1e-3;
  rest = make(model_, scene, options)->run_to_rest(20000, dt);
  EXPECT_TRUE(rest.converged());
  EXPECT_EQ(rest.message().find("ok: "), 0u) << rest.message();
}

TEST_P(SolverConformance, StopsBeforeNaNAndKeepsTheLastGoodState) {
  const Scene scene(model_);
  const auto solver = make(model_, scene, {.on_unstable = UnstableStep::allow});
  solver->reset(displaced(model_, 0.05, 3));
  const StepReport report = solver->step(1000000, 3.0 * solver->stable_step());
  ASSERT_EQ(report.status, StepStatus::not_finite) << report.message();
  EXPECT_TRUE(report.beyond_limit);
  EXPECT_GE(report.particle, 0);
  const State state = solver->read();
  EXPECT_TRUE(is_finite(state));
  EXPECT_EQ(state.time, report.time);
  EXPECT_TRUE(says(report.message(), "the step is beyond the stable step at rest"));
  solver->reset();
  EXPECT_TRUE(solver->step(10, 0.5 * solver->stable_step()).ok());
}

TEST_P(SolverConformance, ResetInMidRunIsAFreshRun) {
  Scene scene = Scene(model_).fix("x0").gravity({0, 0, -9.81});
  const State start = displaced(model_, 0.05, 2);
  const auto fresh = make(model_, scene), used = make(model_, scene);
  const double dt = 0.4 * fresh->stable_step();
  ASSERT_TRUE(used->step(37, dt).ok());
  for (Solver* solver : {fresh.get(), used.get()}) {
    solver->reset(start);
    ASSERT_TRUE(solver->step(50, dt).ok());
  }
  EXPECT_EQ(used->read(), fresh->read());
}

TEST_P(SolverConformance, BadStatesAndOptionsAreRefused) {
  const Scene scene(model_);
  const auto solver = make(model_, scene);
  const State before = solver->read();
  const auto refused_with = [&](auto change) {
    State bad = before;
    change(bad);
    EXPECT_THROW(solver->reset(bad), Error);
  };
  refused_with([](State& s) { s.position[3].y() = std::nan(""); });
  refused_with([](State& s) { s.velocity[3].y() = std::numeric_limits<double>::infinity(); });
  refused_with([](State& s) { s.time = std::nan(""); });
  refused_with([](State& s) { s.velocity.pop_back(); });
  EXPECT_EQ(solver->read(), before);
  const auto refused = [&](auto SolverOptions::*option, auto value, const char* text) {
    SolverOptions options;
    options.*option = value;
    EXPECT_TRUE(refuses([&] { make(model_, scene, options); }, text));
  };
  for (const double d : {-0.1, 1.01, std::nan("")}) {
    refused(&SolverOptions::damping, Damping{.factor = d}, "damping.factor must be in [0, 1]");
  }
  refused(&SolverOptions::damping, Damping{.rate = -1.0}, "damping.rate must be a finite rate");
  refused(&SolverOptions::rest_tolerance, 0.0, "rest_tolerance must be above 0");
  refused(&SolverOptions::rest_steps, 0, "rest_steps must be 1 or more");
  for (const double push : {0.0, -1.0, std::nan("")}) {
    refused(&SolverOptions::max_displacement_per_step, push, "max_displacement_per_step must be above 0");
  }
}

}  // namespace phymul::test
