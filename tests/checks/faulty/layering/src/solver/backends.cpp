// SPDX-License-Identifier: MIT
#include "cpu/reference.h"
