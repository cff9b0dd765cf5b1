// SPDX-License-Identifier: MIT
//
// The body a case file asks for.
#pragma once

#include <phymul/model.h>

#include "reference_case.h"

namespace phymul::bench {

/// With groups, without material. Throws Error.
Model make_body(const ReferenceCase& reference_case, const Variables& variables);

/// Adds x, y, z of a point to the variables.
Variables at_point(Variables variables, const Vec3& point);

}  // namespace phymul::bench
