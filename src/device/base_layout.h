// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/gl.h>

#include "float_tables.h"

namespace phymul {

/// Of a GL backend: enumerated where it is allowed, and asked for or smaller. What is asked for and not allowed is
/// returned as it is; pack_floats refuses it.
FloatLayout choose_layout(BaseLayout wish, const TopologyTextures& topology);

}  // namespace phymul
