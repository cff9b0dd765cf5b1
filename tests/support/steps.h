// SPDX-License-Identifier: MIT
//
// Steps and rests that must succeed: where they do not, a test says what the report says.
#pragma once

#include <gtest/gtest.h>
#include <phymul/solver.h>

namespace phymul::test {

inline testing::AssertionResult is_ok(const StepReport& report) {
  return (report.ok() ? testing::AssertionSuccess() : testing::AssertionFailure()) << report.message();
}

inline testing::AssertionResult has_converged(const RestResult& rest) {
  return (rest.converged() ? testing::AssertionSuccess() : testing::AssertionFailure()) << rest.message();
}

/// So many steps of `dt`, s, by each solver or pointer to one, in turn; none after one that fails.
template <class... Solvers>
testing::AssertionResult all_step(int steps, double dt, Solvers&&... solvers) {
  testing::AssertionResult result = testing::AssertionSuccess();
  const auto step = [&](auto& solver) {
    if constexpr (requires { solver.step(steps, dt); }) {
      result = is_ok(solver.step(steps, dt));
    } else {
      result = is_ok(solver->step(steps, dt)) << ", of " << solver->name();
    }
    return bool(result);
  };
  (step(solvers) && ...);
  return result;
}

}  // namespace phymul::test
