// SPDX-License-Identifier: MIT
#include "block_matrix.h"

#include <Eigen/LU>
#include <algorithm>

namespace phymul {

BlockMatrix::BlockMatrix(const std::vector<std::vector<Index>>& columns) {
  for (std::size_t row = 0; row < columns.size(); ++row) {
    column_.insert(column_.end(), columns[row].begin(), columns[row].end());
    first_.push_back(static_cast<Index>(column_.size()));
  }
  blocks_.assign(column_.size(), Mat3::Zero());
  for (Index row = 0; row < rows(); ++row) diagonal_.push_back(entry(row, row));
}

void BlockMatrix::set_zero() {
  for (Mat3& block : blocks_) block.setZero();
}

Index BlockMatrix::entry(Index row, Index column) const {
  const auto begin = column_.begin() + first_[row], end = column_.begin() + first_[row + 1];
  return static_cast<Index>(std::lower_bound(begin, end, column) - column_.begin());
}

void BlockMatrix::invert_diagonal() {
  inverse_.clear();
  for (const Index e : diagonal_) inverse_.push_back(blocks_[e].inverse());
}

Vec3 BlockMatrix::row_product(Index row, const Eigen::VectorXd& x) const {
  Vec3 sum = Vec3::Zero();
  for (Index e = first_[row]; e < first_[row + 1]; ++e) {
    const Mat3& A = blocks_[e];
    const double* at = x.data() + 3 * column_[e];
    sum += A.col(0) * at[0] + A.col(1) * at[1] + A.col(2) * at[2];
  }
  return sum;
}

void BlockMatrix::residual(const Eigen::VectorXd& b, const Eigen::VectorXd& x, Eigen::VectorXd& result) const {
  result.resize(b.size());
  for (Index row = 0; row < rows(); ++row) result.segment<3>(3 * row) = b.segment<3>(3 * row) - row_product(row, x);
}

void BlockMatrix::smooth(const Eigen::VectorXd& b, bool rising, Eigen::VectorXd& x) const {
  for (Index k = 0; k < rows(); ++k) {
    const Index row = rising ? k : rows() - 1 - k;
    x.segment<3>(3 * row) += inverse_[row] * (b.segment<3>(3 * row) - row_product(row, x));
  }
}

}  // namespace phymul
