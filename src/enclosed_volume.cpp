// SPDX-License-Identifier: MIT
#include "enclosed_volume.h"

#include <Eigen/Geometry>

namespace phymul {

double enclosed_volume(std::span<const std::array<Index, 3>> triangles, std::span<const Vec3> position) {
  if (triangles.empty()) return 0.0;
  const Vec3 origin = position[triangles.front()[0]];
  double sum = 0.0;
  for (const std::array<Index, 3>& t : triangles) {
    const Vec3 a = position[t[0]] - origin, b = position[t[1]] - origin, c = position[t[2]] - origin;
    sum += a.dot(b.cross(c));
  }
  return sum / 6.0;
}

}  // namespace phymul
