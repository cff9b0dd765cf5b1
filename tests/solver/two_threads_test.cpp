// SPDX-License-Identifier: MIT
//
// A solver stepped by two threads at once, or by what it calls itself, is refused the second step and loses nothing.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <thread>
#include <vector>

#include "support/message_of.h"

namespace phymul {
namespace {

TEST(TwoThreads, AStepWithinAStepIsRefused) {
  const Model model = make_block({0.04, 0.02, 0.02}, 4, 2, 2);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  for (const char* backend : {"cpu", "reference"}) {
    Solver* inner = nullptr;
    std::vector<StepReport> refused;
    SolverOptions options;
    options.progress_seconds = 0.0;
    options.progress = [&](const StepProgress&) {
      const double dt = 0.5 * inner->stable_step();
      refused.push_back(inner->step(1, dt));
      std::thread([&] { refused.push_back(inner->run_to_rest(1, dt).report); }).join();
      return true;
    };
    const auto solver = make_solver(backend, model, scene, {}, options);
    const auto alone = make_solver(backend, model, scene);
    inner = solver.get();
    for (int call = 0; call < 2; ++call) {
      ASSERT_TRUE(solver->step(20, 0.5 * solver->stable_step()).ok());
      ASSERT_TRUE(alone->step(20, 0.5 * alone->stable_step()).ok());
    }
    ASSERT_FALSE(refused.empty());
    for (const StepReport& report : refused) {
      EXPECT_EQ(report.status, StepStatus::invalid_step);
      EXPECT_EQ(report.steps, 0);
      EXPECT_TRUE(says(report.message(), "has not returned yet"));
    }
    EXPECT_TRUE(solver->read() == alone->read()) << backend;
  }
}

/// What is refused is neither recorded nor taken for a step by the history.
TEST(TwoThreads, ARefusedStepLeavesNoTrace) {
  Simulation* inner = nullptr;
  int refused = 0;
  SolverOptions options;
  options.progress_seconds = 0.0;
  options.progress = [&](const StepProgress&) {
    refused += inner->advance(1e-3).ok() ? 0 : 1;
    EXPECT_THROW(inner->unrecorded_solver().reset(), Error);
    return true;
  };
  Simulation sim(make_block({0.04, 0.02, 0.02}, 4, 2, 2),
                 {.material = {.young = 10e3, .poisson = 0.3, .density = 1000}, .backend = "cpu", .solver = options});
  inner = &sim;
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.keep_history(1);
  sim.record();
  ASSERT_TRUE(sim.advance(0.01).ok());
  const double middle = sim.time();
  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_GT(refused, 0);
  const State end = sim.solver().read();
  EXPECT_TRUE(sim.rewind(middle));
  EXPECT_DOUBLE_EQ(sim.time(), middle);
  Simulation again(make_block({0.04, 0.02, 0.02}, 4, 2, 2),
                   {.material = {.young = 10e3, .poisson = 0.3, .density = 1000}, .backend = "cpu"});
  ASSERT_TRUE((again.scene().fix("x0").gravity({0, 0, -9.81}), again.advance(0.01).ok() && again.advance(0.01).ok()));
  EXPECT_TRUE(again.solver().read() == end);
}

}  // namespace
}  // namespace phymul
