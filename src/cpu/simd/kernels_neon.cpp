// SPDX-License-Identifier: MIT
#define PHYMUL_ISA neon
#define PHYMUL_LANES 4
#define PHYMUL_NEON

#include "kernels.h"

namespace phymul::cpu::simd {

const Kernels neon_kernels = neon::all_kernels("neon");

}  // namespace phymul::cpu::simd
