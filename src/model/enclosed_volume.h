// SPDX-License-Identifier: MIT
//
// The volume inside a closed surface of triangles, its gradient, and how far to go along a field of directions to reach
// a wanted volume: V(x + s d) = V(x) + c1 s + c2 s^2 + c3 s^3 is exact, so one root of a cubic is.
#pragma once

#include <phymul/types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <optional>
#include <span>
#include <utility>

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

/// m^3, at an s, and by how much it grows with it: not at all, or it falls.
struct WantedVolume {
  double volume = 0.0, slope = 0.0;
};

/// Nearest zeros of c1 + 2 c2 s + 3 c3 s^2 below and above 0, where it is positive, or infinite.
std::pair<double, double> growing_branch(const std::array<double, 3>& c);

/// The s nearest to 0 with c1 s + c2 s^2 + c3 s^3 = wanted(s), a WantedVolume, on the branch through 0 on which the
/// cubic grows; none where nothing grows or that branch does not reach so far: the way to it would turn the body inside
/// out.
template <std::invocable<double> Wanted>
std::optional<double> root_of_cubic(const std::array<double, 3>& c, const Wanted& wanted) {
  const auto value = [&](double s) { return ((c[2] * s + c[1]) * s + c[0]) * s - wanted(s).volume; };
  const auto slope = [&](double s) { return (3.0 * c[2] * s + 2.0 * c[1]) * s + c[0] - wanted(s).slope; };
  const double missing = -value(0.0);
  if (missing == 0.0 && c[0] > 0.0) return 0.0;
  if (!(c[0] >= 0.0 && slope(0.0) > 0.0) || !std::isfinite(missing) || !std::isfinite(c[0] + c[1] + c[2])) {
    return std::nullopt;
  }
  const std::pair<double, double> ends = growing_branch(c);
  const double end = missing > 0.0 ? ends.second : ends.first;
  const auto up_to_end = [end](double s) { return std::abs(s) > std::abs(end) ? end : s; };
  const auto short_of = [&](double s) { return missing > 0.0 ? value(s) < 0.0 : value(s) > 0.0; };
  double far = up_to_end(missing / slope(0.0));
  for (int k = 0; short_of(far); ++k) {
    if (far == end || k > 1000) return std::nullopt;
    far = up_to_end(2.0 * far);
  }
  // Newton's iteration, kept between 0 and there by halving.
  double low = std::min(0.0, far), high = std::max(0.0, far);
  double s = std::clamp(missing / slope(0.0), low, high);
  for (int k = 0; k < 200; ++k) {
    const double f = value(s);
    (f < 0.0 ? low : high) = s;
    const double newton = s - f / slope(s);
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    if (f == 0.0 || next == s || next == low || next == high) break;
    s = next;
  }
  return s;
}
inline std::optional<double> root_of_cubic(const std::array<double, 3>& c, double wanted) {
  return root_of_cubic(c, [wanted](double) { return WantedVolume{wanted, 0.0}; });
}

}  // namespace phymul
