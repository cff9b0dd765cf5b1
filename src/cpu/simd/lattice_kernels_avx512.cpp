// SPDX-License-Identifier: MIT
#define PHYMUL_ISA avx512
#define PHYMUL_LANES 16

#include "lattice_kernels.h"
