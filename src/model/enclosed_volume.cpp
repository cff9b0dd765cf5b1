// SPDX-License-Identifier: MIT
#include "enclosed_volume.h"

#include <Eigen/Geometry>
#include <limits>

namespace phymul {

namespace {

Vec3 twice_area(const std::array<Index, 3>& t, std::span<const Vec3> position) {
  const Vec3& a = position[t[0]];
  return (position[t[1]] - a).cross(position[t[2]] - a);
}

}  // namespace

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
  // b x c differs from the triangle's own vector by a x (b - c), whose sum around a corner of a closed surface is 0.
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 share = twice_area(t, position) / 6.0;
    for (const Index corner : t) gradient[corner] += share;
  }
}

std::array<double, 3> volume_along(Triangles triangles, std::span<const Vec3> position, std::span<const Vec3> along) {
  std::array<double, 3> c{0.0, 0.0, 0.0};
  if (triangles.empty()) return c;
  const Vec3 origin = position[triangles.front()[0]];
  for (const std::array<Index, 3>& t : triangles) {
    // d . dV/dx(x), x . dV/dx(d) and V(d), with the gradient as above.
    const Vec3 middle = (position[t[0]] + position[t[1]] + position[t[2]]) - 3.0 * origin;
    const Vec3 across = twice_area(t, along);
    c[0] += (along[t[0]] + along[t[1]] + along[t[2]]).dot(twice_area(t, position));
    c[1] += middle.dot(across);
    c[2] += along[t[0]].dot(across);
  }
  for (double& value : c) value /= 6.0;
  return c;
}

}  // namespace phymul
