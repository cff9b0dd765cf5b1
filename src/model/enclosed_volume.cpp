// SPDX-License-Identifier: MIT
#include "enclosed_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace phymul {

std::pair<double, double> growing_branch(const std::array<double, 3>& c) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const double a = 3.0 * c[2], b = c[1], under = b * b - a * c[0];  // halved form: a s^2 + 2 b s + c1
  std::pair<double, double> ends{-infinite, infinite};
  if (under < 0.0) return ends;
  const double q = -(b + std::copysign(std::sqrt(under), b));
  for (const double zero : {q / a, c[0] / q}) {
    if (!std::isfinite(zero)) continue;
    if (zero < 0.0) ends.first = std::max(ends.first, zero);
    if (zero > 0.0) ends.second = std::min(ends.second, zero);
  }
  return ends;
}

double enclosed_volume(Triangles triangles, std::span<const Vec3> position) {
  if (triangles.empty()) return 0.0;
  const Vec3 origin = position[triangles.front()[0]];
  double sum = 0.0;
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 a = position[t[0]] - origin, b = position[t[1]] - origin, c = position[t[2]] - origin;
    sum += a.dot(b.cross(c));
  }
  return sum / 6.0;
}

void volume_gradient(Triangles triangles, std::span<const Vec3> position, std::span<Vec3> gradient) {
  std::fill(gradient.begin(), gradient.end(), Vec3::Zero());
  if (triangles.empty()) return;
  const Vec3 origin = position[triangles.front()[0]];
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 a = position[t[0]] - origin, b = position[t[1]] - origin, c = position[t[2]] - origin;
    gradient[t[0]] += b.cross(c) / 6.0;
    gradient[t[1]] += c.cross(a) / 6.0;
    gradient[t[2]] += a.cross(b) / 6.0;
  }
}

std::array<double, 3> volume_along(Triangles triangles, std::span<const Vec3> position, std::span<const Vec3> along) {
  std::array<double, 3> c{0.0, 0.0, 0.0};
  if (triangles.empty()) return c;
  const Vec3 origin = position[triangles.front()[0]];
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 x = position[t[0]] - origin, y = position[t[1]] - origin, z = position[t[2]] - origin;
    const Vec3 &u = along[t[0]], &v = along[t[1]], &w = along[t[2]];
    c[0] += u.dot(y.cross(z)) + v.dot(z.cross(x)) + w.dot(x.cross(y));
    c[1] += x.dot(v.cross(w)) + y.dot(w.cross(u)) + z.dot(u.cross(v));
    c[2] += u.dot(v.cross(w));
  }
  for (double& value : c) value /= 6.0;
  return c;
}

}  // namespace phymul
