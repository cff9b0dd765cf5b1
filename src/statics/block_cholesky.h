// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCholesky>
#include <vector>

#include "block_matrix.h"

namespace phymul {

/// Solves A x = b for a symmetric, positive definite A of blocks.
class BlockCholesky {
 public:
  /// Finds the order of elimination, once for all matrices with entries at the same places.
  void analyse(const BlockMatrix& matrix);
  void factorise(const BlockMatrix& matrix);
  /// Shapes [3 rows].
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

 private:
  std::vector<Index> row_at_;             // in the order of elimination
  std::vector<Index> entries_;            // of the upper triangle in that order, by columns; the diagonal's is the last
  std::vector<std::size_t> first_entry_;  // [rows + 1]
  Eigen::SparseMatrix<double> upper_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Upper, Eigen::NaturalOrdering<int>> factors_;
  Eigen::VectorXd ordered_;
};

}  // namespace phymul
