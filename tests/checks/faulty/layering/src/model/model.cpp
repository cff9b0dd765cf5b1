// SPDX-License-Identifier: MIT
#include "elastic/forces_of.h"
