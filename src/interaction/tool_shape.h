// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/tool.h>

#include "distance_to_shape.h"

namespace phymul::cpu {

/// As distance_to() takes it; points to the values of a grid, which must outlive it. Nothing of a needle.
ShapeIn<double> shape_of(const Tool& tool);

}  // namespace phymul::cpu
