// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <Eigen/SVD>

namespace phymul {

/// The rotation nearest to F.
inline Mat3 rotation_of(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

}  // namespace phymul
