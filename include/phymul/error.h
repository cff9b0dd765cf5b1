// SPDX-License-Identifier: MIT
//
// Tier one of three: building (reading files, making models, scenes and solvers) throws phymul::Error.
// Stepping never throws: it returns a StepReport. Misuse by the programmer asserts in debug builds.
#pragma once

#include <stdexcept>
#include <string>

namespace phymul {

/// What went wrong, where, what was expected, what came, what to do; for files as "file:line: ...".
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace phymul
