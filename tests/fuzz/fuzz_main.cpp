// SPDX-License-Identifier: MIT
//
// What libFuzzer calls; PHYMUL_FUZZ_TARGET is the name of one target.
#include <cstdint>

#include "fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  phymul::fuzz::PHYMUL_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
