// SPDX-License-Identifier: MIT
//
// What an Error says.
#pragma once

#include <gtest/gtest.h>
#include <phymul/error.h>

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

/// That a text has this part; the text, where it has not.
inline testing::AssertionResult says(std::string_view text, std::string_view part) {
  if (text.find(part) != std::string_view::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "no \"" << part << "\" in: " << text;
}

/// That `action` throws an Error whose text has this part.
template <class Action>
testing::AssertionResult refuses(Action action, std::string_view part) {
  return says(message_of(action), part);
}

}  // namespace phymul
