// SPDX-License-Identifier: MIT
#pragma once

#include "compiler.h"

namespace phymul {

/// While it lives, this thread takes numbers below 1e-38 for 0: a body that comes to rest passes through them, and many
/// processors need a hundred times longer for each. Collapsed bodies do too, and end at the same bits on x86-64 and ARM
/// only if both do it.
class DenormalsAreZero {
 public:
  DenormalsAreZero() : before_(float_control()) { set_float_control(before_ | denormals_are_zero); }
  ~DenormalsAreZero() { set_float_control(before_); }
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;

 private:
  unsigned long long before_;
};

}  // namespace phymul
