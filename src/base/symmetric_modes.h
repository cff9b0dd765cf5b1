// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>

namespace phymul {

/// Eigenvalues, rising, and eigenvectors, one a column. They are found in one file, because Eigen's solver takes
/// seconds to compile for each size of matrix.
struct SymmetricModes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Of a symmetric matrix.
SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix);

/// Of a symmetric tridiagonal one. `off`: the values beside the diagonal, one fewer; what follows them is not read.
SymmetricModes tridiagonal_modes(std::span<const double> diagonal, std::span<const double> off);

}  // namespace phymul
