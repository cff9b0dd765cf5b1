// SPDX-License-Identifier: MIT
//
// The body a case file asks for.
#pragma once

#include <phymul/model.h>

#include "reference_case.h"

namespace phymul::bench {

/// With groups, without material. Throws Error.
Model make_body(const ReferenceCase& it, const Variables& variables);

Vec3 vector_of(const Triple& texts, const Variables& variables);

/// Adds x, y, z of a place in the mapped body to the variables, and the case's fields there.
Variables at_point(const ReferenceCase& it, Variables variables, const Vec3& point);

}  // namespace phymul::bench
