// SPDX-License-Identifier: MIT
#define PHYMUL_ISA avx2
#define PHYMUL_LANES 8

#include "lattice_kernels.h"
