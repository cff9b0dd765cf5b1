// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>
#include "solver_internals.h"
