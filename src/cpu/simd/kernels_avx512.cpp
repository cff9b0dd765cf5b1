// SPDX-License-Identifier: MIT
#define PHYMUL_ISA avx512
#define PHYMUL_LANES 16

#include "kernels.h"

namespace phymul::cpu::simd {

const Kernels avx512_kernels = avx512::all_kernels("avx512");

}  // namespace phymul::cpu::simd
