// SPDX-License-Identifier: MIT
#include "dense_operator.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

namespace phymul::test {
namespace {

/// M^-1 K of the free coordinates; rows and columns of the others are 0.
Eigen::MatrixXd dense_operator(const TopologyTextures& topology, const VecList& position,
                               const std::vector<std::uint8_t>& fixed = {}) {
  const auto n = static_cast<Eigen::Index>(3 * position.size());
  const double step = 1e-4 * (topology.rest[1] - topology.rest[0]).norm();
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  const auto is_free = [&](Eigen::Index row) {
    return row % 3 < topology.dimension && (fixed.empty() || (fixed[row / 3] >> (row % 3) & 1) == 0);
  };
  VecList plus(position.size()), minus(position.size());
  for (Eigen::Index column = 0; column < n; ++column) {
    if (!is_free(column)) continue;
    VecList x = position;
    x[column / 3][column % 3] += step;
    elastic_forces(topology, x, plus);
    x[column / 3][column % 3] -= 2.0 * step;
    elastic_forces(topology, x, minus);
    for (Eigen::Index row = 0; row < n; ++row) {
      if (is_free(row))
        k(row, column) = (minus[row / 3] - plus[row / 3])[row % 3] / (2.0 * step * topology.mass[row / 3]);
    }
  }
  return k;
}

}  // namespace

Eigen::VectorXcd dense_eigenvalues(const TopologyTextures& topology, const VecList& position,
                                   const std::vector<std::uint8_t>& fixed) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(dense_operator(topology, position, fixed), false).eigenvalues();
}

GrowingMode fastest_growing_mode(const TopologyTextures& topology) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(dense_operator(topology, topology.rest));
  const Eigen::VectorXcd values = solver.eigenvalues();
  GrowingMode mode;
  mode.highest_frequency = std::sqrt(values.cwiseAbs().maxCoeff());
  Eigen::Index best = -1;
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (std::abs(values[k]) < 1e-6 * std::pow(mode.highest_frequency, 2)) continue;
    std::complex<double> s = std::sqrt(-values[k]);
    if (s.real() < 0.0) s = -s;
    if (best >= 0 && s.real() <= mode.s.real()) continue;
    best = k;
    mode.s = s;
  }
  const Eigen::MatrixXcd vectors = solver.eigenvectors();
  Eigen::Index largest = 0;
  vectors.col(best).cwiseAbs().maxCoeff(&largest);
  mode.shape = vectors.col(best) / vectors(largest, best);
  Eigen::VectorXcd wish = Eigen::VectorXcd::Zero(values.size());
  wish[best] = 1.0;
  // Row `best` of the inverse of the matrix of eigenvectors: picks * vectors = wish.
  mode.picks = vectors.transpose().partialPivLu().solve(wish).transpose();
  return mode;
}

}  // namespace phymul::test
