// SPDX-License-Identifier: MIT
#include "reference.h"
#include "../gl/context.h"
#include <EGL/egl.h>
