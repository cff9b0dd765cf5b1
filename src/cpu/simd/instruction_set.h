// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "job.h"

namespace phymul::cpu::simd {

/// Instruction sets that this build has kernels for and this processor can run, best last.
std::vector<const Kernels*> usable_kernels();

/// The best of them, or the one named by the environment variable PHYMUL_CPU_ISA (portable, neon, avx2, avx512). Throws
/// Error for another name, and for one that this processor lacks.
const Kernels& chosen_kernels();

}  // namespace phymul::cpu::simd
