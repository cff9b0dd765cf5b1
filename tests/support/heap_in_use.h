// SPDX-License-Identifier: MIT
//
// What this process has taken from the heap and not given back: what a leak adds to. Resident memory would also show
// what the heap keeps for itself. 0 under sanitizers, whose own leak checkers count there.
#pragma once

#include <malloc.h>

namespace phymul::test {

inline double heap_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);  // bytes
}

}  // namespace phymul::test
