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
/// volume, m^3. `adjust` may change what is filled. Throws Error as make_body() does, but not for the volume.
Model filled_body(const Interior& interior, const CentredLattice& lattice, double wanted_volume,
                  const BodyOptions& options, BodyReport& report, const std::function<void(Stuffing&)>& adjust = {});

/// Throws Error for an error of the volume above options.most_volume_error. `thin` says what is lost of the shape;
/// empty text: nothing, so that edges and corners are the cause; without the function both may be.
void require_volume(const BodyReport& report, const BodyOptions& options, const std::function<std::string()>& thin);

}  // namespace phymul
