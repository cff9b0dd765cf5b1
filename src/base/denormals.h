// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "compiler.h"

// Emscripten, which writes SSE2 by WebAssembly's vectors, has no such register.
#if defined(__SSE2__) && !defined(__EMSCRIPTEN__)
#include <xmmintrin.h>
#endif

namespace phymul::cpu {

/// While it lives, this thread takes numbers below 1e-38 for 0: a body that comes to rest passes through them, and many
/// processors need a hundred times longer for each. Collapsed bodies do too, and end at the same bits on x86-64 and ARM
/// only if both do it.
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
#elif defined(__aarch64__)
  DenormalsAreZero() {
    PHYMUL_READ_FPCR(before_);
    PHYMUL_WRITE_FPCR(before_ | std::uint64_t{1} << 24);  // FZ
  }
  ~DenormalsAreZero() {
    PHYMUL_WRITE_FPCR(before_);
  }

 private:
  std::uint64_t before_ = 0;
#else
  DenormalsAreZero() {}
  ~DenormalsAreZero() {}

 public:
#endif
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;
};

}  // namespace phymul::cpu
