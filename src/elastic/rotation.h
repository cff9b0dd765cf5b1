// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <Eigen/LU>
#include <cmath>

#include "elastic/energy_density.h"

namespace phymul {

/// The rotation nearest to F.
Mat3 rotation_of(const Mat3& F);

/// rotation_of(F), sooner unless F is nearly flat or inside out: by Newton's method for the polar
/// decomposition (N. Higham, SIAM J. Sci. Stat. Comput. 7 (1986) 1160-1174).
inline Mat3 polar_rotation(const Mat3& F) {
  constexpr double flat = 0.05;  // of the determinant of a matrix of the same norm that is a multiple of a rotation
  const double determinant = F.determinant(), size = F.norm() / std::sqrt(3.0);
  if (!(determinant > flat * size * size * size)) return rotation_of(F);
  Mat3 R = F / std::cbrt(determinant);
  for (int k = 0; k < 10; ++k) {
    const Mat3 change = 0.5 * (cofactor<double>(R) / R.determinant() - R);
    R += change;
    if (change.squaredNorm() < 1e-16) break;  // the next one is about its square
  }
  return R;
}

}  // namespace phymul
