// SPDX-License-Identifier: MIT
#define PHYMUL_ISA avx2
#define PHYMUL_LANES 8

#include "kernels.h"

namespace phymul::cpu::simd {

const Kernels avx2_kernels = avx2::all_kernels("avx2");

}  // namespace phymul::cpu::simd
