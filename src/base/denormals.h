// SPDX-License-Identifier: MIT
#pragma once

// Emscripten, which writes SSE2 by WebAssembly's vectors, has no such register.
#if defined(__SSE2__) && !defined(__EMSCRIPTEN__)
#include <xmmintrin.h>
#endif

namespace phymul::cpu {

/// While it lives, this thread takes numbers below 1e-38 for 0: a body that comes to rest passes through them, and many
/// processors need a hundred times longer for each.
class DenormalsAreZero {
 public:
#if defined(__SSE2__) && !defined(__EMSCRIPTEN__)
  DenormalsAreZero() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | 0x8040);
  }  // FTZ, DAZ
  ~DenormalsAreZero() {
    _mm_setcsr(before_);
  }

 private:
  unsigned before_;
#else
  DenormalsAreZero() {}
  ~DenormalsAreZero() {}

 public:
#endif
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;
};

}  // namespace phymul::cpu
