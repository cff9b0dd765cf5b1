// SPDX-License-Identifier: MIT
#include "symmetric_modes.h"

#include <Eigen/Eigenvalues>

namespace phymul {
namespace {

using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

SymmetricModes found_by(const Solver& solver) {
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace

SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix) {
  return found_by(Solver(matrix));
}

SymmetricModes tridiagonal_modes(std::span<const double> diagonal, std::span<const double> off) {
  using Values = Eigen::Map<const Eigen::VectorXd>;
  const auto size = static_cast<Eigen::Index>(diagonal.size());
  Solver solver;
  solver.computeFromTridiagonal(Values(diagonal.data(), size), Values(off.data(), size - 1));
  return found_by(solver);
}

}  // namespace phymul
