// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/error.h>

namespace phymul::gl {

/// A context that is there, but cannot be made current now: the host has another one current, or it is on another
/// thread.
struct Unreachable : Error {
  using Error::Error;
};

}  // namespace phymul::gl
