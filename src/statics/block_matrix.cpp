// SPDX-License-Identifier: MIT
#include "block_matrix.h"

#include <Eigen/LU>
#include <algorithm>

namespace phymul {

BlockMatrix::BlockMatrix(const std::vector<std::vector<Index>>& columns) {
  for (const std::vector<Index>& row : columns) {
    column_.insert(column_.end(), row.begin(), row.end());
    first_.push_back(static_cast<Index>(column_.size()));
  }
  blocks_.assign(column_.size(), PaddedMatrix::Zero());
}

void BlockMatrix::set_zero() {
  std::ranges::fill(blocks_, PaddedMatrix::Zero());
}

Index BlockMatrix::entry(Index row, Index column) const {
  const auto begin = column_.begin() + first_[row], end = column_.begin() + first_[row + 1];
  return static_cast<Index>(std::lower_bound(begin, end, column) - column_.begin());
}

void BlockMatrix::invert_diagonal() {
  inverse_.clear();
  for (Index row = 0; row < rows(); ++row) {
    const Mat3 block = blocks_[entry(row, row)].topRows<3>().cast<double>();
    inverse_.push_back(padded(block.inverse()));
  }
}

Eigen::Vector4f BlockMatrix::row_residual(Index row, const PaddedVectors& b, const PaddedVectors& x) const {
  Eigen::Vector4f left = b[row];
  for (Index e = first_[row]; e < first_[row + 1]; ++e) left -= product(blocks_[e], x[column_[e]]);
  return left;
}

void BlockMatrix::residual(const PaddedVectors& b, const PaddedVectors& x, PaddedVectors& result) const {
  for (Index row = 0; row < rows(); ++row) result[row] = row_residual(row, b, x);
}

void BlockMatrix::smooth(const PaddedVectors& b, bool rising, PaddedVectors& x) const {
  for (Index k = 0; k < rows(); ++k) {
    const Index row = rising ? k : rows() - 1 - k;
    x[row] += product(inverse_[row], row_residual(row, b, x));
  }
}

}  // namespace phymul
