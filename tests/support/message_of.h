// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/error.h>

#include <string>

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

}  // namespace phymul
