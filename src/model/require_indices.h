// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/error.h>
#include <phymul/types.h>

#include <string>

namespace phymul {

/// Throws Error for the first index that is not from 0 to count - 1. `what` they are: "particles". `label()` says
/// where, with a colon and a blank behind it; it is asked only then.
template <class Indices, class Label>
void require_indices(const Indices& indices, std::size_t count, const char* what, const Label& label,
                     ErrorCode code = ErrorCode::invalid_argument) {
  for (const Index index : indices) {
    if (index >= 0 && static_cast<std::size_t>(index) < count) continue;
    throw Error(code, label() + "expected " + what + " from 0 to " + std::to_string(static_cast<long long>(count) - 1) +
                          ", got " + std::to_string(index));
  }
}

}  // namespace phymul
