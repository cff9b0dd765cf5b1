// SPDX-License-Identifier: MIT
#define PHYMUL_ISA portable
#define PHYMUL_LANES 4

#include "kernels.h"

namespace phymul::cpu::simd {

const Kernels portable_kernels = portable::all_kernels("portable");

}  // namespace phymul::cpu::simd
