// SPDX-License-Identifier: MIT
#include "../src/gl/context.h"
