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
