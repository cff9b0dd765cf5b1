// SPDX-License-Identifier: MIT
//
// The volume inside a closed surface of triangles, its gradient, and how it grows along a field of directions:
// V(x + s d) = c0 + c1 s + c2 s^2 + c3 s^3, exactly.
#pragma once

#include <phymul/types.h>

#include <array>
#include <span>

namespace phymul {

/// m^3; the sum of the tetrahedra over the first triangle's first corner, which keeps digits far from the origin.
double enclosed_volume(std::span<const std::array<Index, 3>> triangles, std::span<const Vec3> position);

}  // namespace phymul
