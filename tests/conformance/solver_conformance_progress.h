// SPDX-License-Identifier: MIT
//
// What every backend must do in calls that tell how far they are, and when values of a scene change between them.
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>

#include "solver_conformance_fixture.h"
#include "support/message_of.h"

namespace phymul::test {

TEST_P(SolverConformance, ProgressChangesNoBitAndNoCount) {
  Scene scene = Scene(model_).fix("z1").gravity({0, 0, -9.81});
  SolverOptions options{.damping = {.rate = 60.0}, .rest_tolerance = 1e-3};
  const auto plain = make(model_, scene, options);
  std::vector<StepProgress> told;
  options.progress = [&](const StepProgress& progress) {
    told.push_back(progress);
    return true;
  };
  options.progress_seconds = 0.0;
  const auto telling = make(model_, scene, options);
  const double dt = 0.5 * plain->stable_step();
  for (const int before : {0, 7}) {  // steps of an earlier call count too
    SCOPED_TRACE(before);
    plain->reset();
    telling->reset();
    plain->step(before, dt);
    telling->step(before, dt);
    told.clear();
    const RestResult expected = plain->run_to_rest(20000, dt), rest = telling->run_to_rest(20000, dt);
    ASSERT_TRUE(expected.converged());
    EXPECT_TRUE(rest.converged());
    EXPECT_FALSE(rest.report.stopped);
    EXPECT_EQ(rest.report.steps, expected.report.steps);
    EXPECT_EQ(rest.report.residual, expected.report.residual);
    EXPECT_EQ(rest.report.max_speed, expected.report.max_speed);
    EXPECT_EQ(telling->read(), plain->read());
    ASSERT_EQ(static_cast<int>(told.size()), rest.report.steps - 1);  // after every step but the last
    for (std::size_t k = 0; k < told.size(); ++k) {
      EXPECT_EQ(told[k].steps, static_cast<int>(k) + 1);
      EXPECT_EQ(told[k].of, 20000);
      EXPECT_GT(told[k].residual, 0.0);
    }
    EXPECT_NEAR(told.back().time, rest.report.time - dt, 1e-9 * rest.report.time);
  }
}

TEST_P(SolverConformance, ProgressEndsACallBetweenSteps) {
  Scene scene = Scene(model_).fix("z1").gravity({0, 0, -9.81});
  SolverOptions options;
  const auto plain = make(model_, scene, options);
  options.progress_seconds = 0.0;
  options.progress = [](const StepProgress& progress) { return progress.steps < 5; };
  const auto stopping = make(model_, scene, options);
  const double dt = 0.5 * plain->stable_step();
  const StepReport report = stopping->step(100, dt);
  EXPECT_TRUE(report.ok());
  EXPECT_TRUE(report.stopped);
  EXPECT_TRUE(says(report.message(), "stopped"));
  EXPECT_EQ(report.steps, 5);
  EXPECT_FALSE(plain->step(5, dt).stopped);
  EXPECT_EQ(stopping->read(), plain->read());
  EXPECT_FALSE(stopping->step(5, dt).stopped);  // it is asked between steps, and there is none after the fifth
  plain->step(5, dt);
  EXPECT_EQ(stopping->read(), plain->read());
}

TEST_P(SolverConformance, WhatProgressThrowsLeavesASolverThatGoesOn) {
  Scene scene = Scene(model_).fix("z1").gravity({0, 0, -9.81});
  SolverOptions options;
  const auto plain = make(model_, scene, options);
  bool angry = true;
  options.progress_seconds = 0.0;
  options.progress = [&angry](const StepProgress& progress) {
    if (angry && progress.steps == 3) throw std::runtime_error("enough");
    return true;
  };
  const auto throwing = make(model_, scene, options);
  const double dt = 0.5 * plain->stable_step();
  EXPECT_THROW(throwing->step(100, dt), std::runtime_error);
  plain->step(3, dt);
  EXPECT_EQ(throwing->read(), plain->read());
  angry = false;
  EXPECT_EQ(throwing->step(10, dt).steps, 10);
  plain->step(10, dt);
  EXPECT_EQ(throwing->read(), plain->read());
}

TEST_P(SolverConformance, ProgressTellsOfFailuresAsEver) {
  const Scene scene(model_);
  SolverOptions options{.on_unstable = UnstableStep::allow};
  const auto plain = make(model_, scene, options);
  options.progress_seconds = 0.0;
  options.progress = [](const StepProgress&) { return true; };
  const auto telling = make(model_, scene, options);
  const State start = displaced(model_, 0.05, 3);
  plain->reset(start);
  telling->reset(start);
  const double dt = 3.0 * plain->stable_step();
  const StepReport expected = plain->step(10000, dt), report = telling->step(10000, dt);
  ASSERT_EQ(expected.status, StepStatus::not_finite);
  EXPECT_EQ(report.status, StepStatus::not_finite);
  EXPECT_EQ(report.steps, expected.steps);
  EXPECT_EQ(report.particle, expected.particle);
  EXPECT_EQ(report.max_speed, expected.max_speed);
  EXPECT_EQ(telling->read(), plain->read());
}

TEST_P(SolverConformance, ProgressIsToldNoMoreOftenThanAsked) {
  const Scene scene(model_);
  int calls = 0;
  SolverOptions options{.progress = [&calls](const StepProgress&) { return ++calls > 0; }, .progress_seconds = 3600.0};
  const auto solver = make(model_, scene, options);
  EXPECT_EQ(solver->step(300, 0.5 * solver->stable_step()).steps, 300);
  EXPECT_EQ(calls, 0);
  options.progress_seconds = -1.0;
  EXPECT_THROW(make(model_, scene, options), Error);
}

TEST_P(SolverConformance, NewValuesOfALoadActLikeANewLoad) {
  Scene replaced(model_), driven(model_);
  Load pull, push;
  pull.type = LoadType::translation;
  pull.particles = model_.group("z1");
  pull.axes = {Axis::driven, Axis::free, Axis::free};
  pull.direction = {1, 0, 0};
  pull.events = {{0.0, 0.0}, {1.0, 0.0}};
  push = pull;
  push.type = LoadType::force;
  push.particles = model_.group("x0");
  Load turn = pull;
  turn.type = LoadType::rotation;
  turn.particles = model_.group("y1");
  for (Scene* scene : {&replaced, &driven}) scene->add({pull, push, turn}).fix("z0");
  const auto a = make(model_, replaced), b = make(model_, driven);
  const double dt = 0.5 * a->stable_step();
  for (int k = 1; k <= 5; ++k) {
    const double now = b->read().time;
    pull.events = {{now, 1e-4 * (k - 1)}, {now + 4 * dt, 1e-4 * k}};
    push.events = {{now, 1e-3 * k}};
    turn.events = {{now, 1e-3 * k}};
    replaced.replace(0, pull).replace(1, push).replace(2, turn);
    driven.set_events(0, pull.events).set_events(1, push.events).set_events(2, turn.events);
    ASSERT_TRUE(all_step(4, dt, a, b));
    ASSERT_EQ(a->read(), b->read()) << k;
  }
  EXPECT_NE(b->read(), rest_state(model_));
}

TEST_P(SolverConformance, NewValuesStartTheCountOfStepsAtRestAnew) {
  Scene scene(model_);
  Load pull{
      .type = LoadType::translation, .particles = model_.group("z1"), .events = {{0.0, 0.0}}, .direction = {1, 0, 0}};
  scene.add(pull);
  const auto solver = make(model_, scene);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(20, dt).at_rest);
  pull.events[0].value = 1e-5;
  scene.set_events(0, pull.events);
  EXPECT_FALSE(solver->step(1, dt).at_rest);
}

}  // namespace phymul::test
