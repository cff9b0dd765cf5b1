// SPDX-License-Identifier: MIT
#include <phymul/elasticity.h>
