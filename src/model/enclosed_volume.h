// SPDX-License-Identifier: MIT
//
// The volume inside a closed surface of triangles, its gradient, and how far to go along a field of directions to reach
// a wanted volume: V(x + s d) = V(x) + c1 s + c2 s^2 + c3 s^3 is exact, so one root of a cubic is.
#pragma once

#include <phymul/types.h>

#include <array>
#include <optional>
#include <span>

namespace phymul {

using Triangles = std::span<const std::array<Index, 3>>;

/// Of a volume: what is missing of one that nothing free can make up for is rounding of single precision up to here. It
/// grows with the way: this much a body turned and carried a thousand times its size may show.
inline constexpr double rounded_volume_share = 1e-4;

/// m^3; the sum of the tetrahedra over the first triangle's first corner, which keeps digits far from the origin.
double enclosed_volume(Triangles triangles, std::span<const Vec3> position);

/// dV/dx, m^2; overwrites `gradient`. Of a closed surface the sum is 0, and that of x cross gradient.
void volume_gradient(Triangles triangles, std::span<const Vec3> position, std::span<Vec3> gradient);

/// c1, c2, c3 of V(x + s d) - V(x).
std::array<double, 3> volume_along(Triangles triangles, std::span<const Vec3> position, std::span<const Vec3> along);

/// The s nearest to 0 with c1 s + c2 s^2 + c3 s^3 = wanted, on the branch through 0 on which the cubic grows; none
/// where c1 is not positive or that branch does not reach so far: the way to it would turn the body inside out.
std::optional<double> root_of_cubic(const std::array<double, 3>& c, double wanted);

}  // namespace phymul
