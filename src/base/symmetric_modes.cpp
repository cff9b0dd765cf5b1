// SPDX-License-Identifier: MIT
#include "symmetric_modes.h"

#include <Eigen/Eigenvalues>

namespace phymul {
namespace {

using EigenSolver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

SymmetricModes found_by(const EigenSolver& solver) {
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace

SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix) {
  return found_by(EigenSolver(matrix));
}

SymmetricModes tridiagonal_modes(std::span<const double> diagonal, std::span<const double> off) {
  using Values = Eigen::Map<const Eigen::VectorXd>;
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  EigenSolver solver;
  solver.computeFromTridiagonal(Values(diagonal.data(), size), Values(off.data(), size - 1));
  return found_by(solver);
}

}  // namespace phymul
