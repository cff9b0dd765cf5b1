// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <Eigen/Geometry>

namespace phymul {

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
