// SPDX-License-Identifier: MIT
//
// The nearest point of a closed surface of triangles, and on which side of it a point lies. The volume inside a closed
// surface of triangles, its gradient, and how far to go along a field of directions to reach a wanted volume: V(x + s
// d) = V(x) + c1 s + c2 s^2 + c3 s^3 is exact, so one root of a cubic is.
#pragma once

#include <phymul/types.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/box_tree.h"

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

using Triangle = std::array<Index, 3>;

/// Signed distances from triangles that form a closed surface, counter-clockwise seen from outside. The sign is that of
/// the normal at the nearest face, edge or corner, angle-weighted there (J. A. Baerentzen, H. Aanaes, "Signed distance
/// computation using the angle weighted pseudonormal", IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253).
class ClosestTriangle {
 public:
  /// Copies both. The surface must be closed (open_edge), and no triangle flat (flat_triangle).
  ClosestTriangle(std::span<const Vec3> place, std::span<const Triangle> triangles);
  double signed_distance(const Vec3& x) const;  ///< m, negative inside

 private:
  struct Nearest {
    double squared;
    Vec3 way;     // from the nearest point to x
    Vec3 normal;  // there, of any length
  };
  void visit(Index own, const Vec3& x, Nearest& nearest) const;
  void look_at(Index triangle, const Vec3& x, Nearest& nearest) const;

  VecList place_;
  std::vector<Triangle> triangle_;                // in the order of the tree's items
  VecList face_normal_;                           // [triangles] unit
  std::vector<std::array<Vec3, 3>> edge_normal_;  // [triangles] of edges k, k + 1
  VecList corner_normal_;                         // [places]
  BoxTree tree_;                                  // over the triangles' middles
  std::vector<Eigen::AlignedBox3d> boxes_;        // [nodes]
};

VecList middles_of(std::span<const Vec3> place, std::span<const Triangle> triangles);

/// An edge that two triangles do not share in opposite directions, as its two places; {-1, -1} where the surface is
/// closed.
std::array<Index, 2> open_edge(std::span<const Triangle> triangles);

/// The row of a triangle without area up to rounding, so that its normal says nothing; -1: there is none.
Index flat_triangle(std::span<const Vec3> place, std::span<const Triangle> triangles);

/// Barycentric coordinates of the point of triangle a, b, c that is nearest to p, by the regions of its corners and
/// edges (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5). A triangle without area gives one of its corners or
/// a point of an edge.
inline Vec3 closest_point(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {0, 1, 0};
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {0, 0, 1};
  const double over_ab = d1 * d4 - d3 * d2;
  if (over_ab <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double t = d1 / (d1 - d3);
    return {1.0 - t, t, 0};
  }
  const double over_ac = d5 * d2 - d1 * d6;
  if (over_ac <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double t = d2 / (d2 - d6);
    return {1.0 - t, 0, t};
  }
  const double over_bc = d3 * d6 - d5 * d4;
  if (over_bc <= 0.0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1.0 - t, t};
  }
  const double whole = over_ab + over_ac + over_bc;
  if (!(whole > 0.0)) return {1, 0, 0};
  const double v = over_ac / whole, w = over_ab / whole;
  return {1.0 - v - w, v, w};
}

}  // namespace phymul
