// SPDX-License-Identifier: MIT
#define PHYMUL_ISA portable
#define PHYMUL_LANES 4

#include "lattice_kernels.h"
