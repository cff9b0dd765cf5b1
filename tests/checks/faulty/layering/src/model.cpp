// SPDX-License-Identifier: MIT
#include "forces_of.h"
