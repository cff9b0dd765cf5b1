// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <Eigen/Geometry>
#include <span>

namespace phymul {

/// Empty, as Eigen has it, where there are no places.
inline Eigen::AlignedBox3d bounding_box(std::span<const Vec3> places) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : places) box.extend(x);
  return box;
}

}  // namespace phymul
