// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

namespace phymul {

/// Products of the coordinates of a vector: xx, yy, zz, xy, yz, zx.
using Products = Eigen::Matrix<double, 6, 1>;

inline Products products(const Vec3& x) {
  return {x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.x() * x.y(), x.y() * x.z(), x.z() * x.x()};
}

/// (p . x) (q . x) is their dot product with products(x).
inline Products product_weights(const Vec3& p, const Vec3& q) {
  const Mat3 both = p * q.transpose();
  return {
      both(0, 0), both(1, 1), both(2, 2), both(0, 1) + both(1, 0), both(1, 2) + both(2, 1), both(2, 0) + both(0, 2)};
}

}  // namespace phymul
