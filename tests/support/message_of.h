// SPDX-License-Identifier: MIT
//
// What an Error says. Steps and rests that must succeed: where they do not, a test says what the report says.
#pragma once

#include <gtest/gtest.h>
#include <phymul/error.h>
#include <phymul/solver.h>

#include <string>
#include <string_view>

namespace phymul {

/// What the Error that `action` throws says; "(no error)" when it throws none.
template <class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "(no error)";
}

/// That a text has this part, and more; the text, where it has not.
template <class... Parts>
testing::AssertionResult says(std::string_view text, std::string_view part, const Parts&... more) {
  if (text.find(part) == std::string_view::npos) {
    return testing::AssertionFailure() << "no \"" << part << "\" in: " << text;
  }
  if constexpr (sizeof...(more) > 0) return says(text, more...);
  return testing::AssertionSuccess();
}

/// That `action` throws an Error whose text has these parts.
template <class Action, class... Parts>
testing::AssertionResult refuses(Action action, const Parts&... parts) {
  return says(message_of(action), parts...);
}

}  // namespace phymul

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
