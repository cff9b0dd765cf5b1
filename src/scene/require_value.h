// SPDX-License-Identifier: MIT
//
// Checks that several parts of a scene share.
#pragma once

#include <phymul/error.h>

#include <cmath>
#include <string>
#include <string_view>

#include "base/decimal.h"

namespace phymul {

/// `label`: what is refused, with a colon after it.
inline void require_not_negative(std::string_view label, const char* what, double value) {
  if (value >= 0.0 && std::isfinite(value)) return;
  throw Error(std::string(label) + "expected a finite " + what + ", 0 or more; got " + to_decimal(value));
}

}  // namespace phymul
