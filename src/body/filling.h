// SPDX-License-Identifier: MIT
//
// From a shape to a model: the lattice over its box, the filling, and what is reported about it.
#pragma once

#include <phymul/body.h>

#include <functional>

#include "interior.h"
#include "stuffing.h"

namespace phymul {

/// Throws Error "make_body: <what>".
[[noreturn]] void refuse_body(const std::string& what);

/// Over the box and a cube around it, with the box in the middle. Throws Error for options out of range.
CentredLattice lattice_over(const Vec3& low, const Vec3& high, const BodyOptions& options);

/// The points inside of the lattice, graded as options.spacing_at asks, as a model whose surface is moved to meet the
/// volume, m^3. `adjust` may change what is filled. Throws Error as make_body() does.
Model filled_body(const Interior& interior, const CentredLattice& lattice, double wanted_volume,
                  const BodyOptions& options, BodyReport* report, const std::function<void(Stuffing&)>& adjust = {});

}  // namespace phymul
