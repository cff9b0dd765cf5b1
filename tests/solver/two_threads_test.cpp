// SPDX-License-Identifier: MIT
//
// A solver stepped by two threads at once, or by what it calls itself, is refused the second step and loses nothing.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <string>
#include <thread>
#include <vector>

namespace phymul {
namespace {

TEST(TwoThreads, AStepWithinAStepIsRefused) {
  const Model model = make_block({0.04, 0.02, 0.02}, 4, 2, 2);
  Scene scene(model);
  scene.fix("x0").gravity({0, 0, -9.81});
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
      EXPECT_NE(report.message().find("has not returned yet"), std::string::npos) << report.message();
    }
    EXPECT_TRUE(solver->read() == alone->read()) << backend;
  }
}

}  // namespace
}  // namespace phymul
