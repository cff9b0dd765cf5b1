// SPDX-License-Identifier: MIT
#include "block_matrix.h"

#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace phymul {

BlockMatrix::BlockMatrix(std::vector<Index> first, std::vector<Index> column)
    : first_(std::move(first)), column_(std::move(column)), blocks_(9 * column_.size() + 1, 0.0f) {
  for (Index row = 0; row < rows(); ++row) {
    const auto begin = column_.begin() + first_[row], end = column_.begin() + first_[row + 1];
    diagonal_.push_back(static_cast<Index>(std::find(begin, end, row) - column_.begin()));
    reach_ = std::max(reach_, 1 + *(end - 1) - row);
  }
}

void BlockMatrix::set_zero() {
  std::ranges::fill(blocks_, 0.0f);
}

void BlockMatrix::invert_diagonal() {
  inverse_.clear();
  for (Index row = 0; row < rows(); ++row) {
    inverse_.push_back(padded(at(diagonal_[row]).cast<double>().inverse()));
  }
}

/// Of b - A x; the fourth number is arbitrary. `step`: 1 or -1, through the row as the caller goes through the rows, so
/// that the processor sees what is read next.
template <int step>
PHYMUL_INLINE Eigen::Vector4f BlockMatrix::residual(Index row, const PaddedVectors& b, const PaddedVectors& x) const {
  const Index begin = step > 0 ? first_[row] : first_[row + 1] - 1, end = step > 0 ? first_[row + 1] : first_[row] - 1;
  const float* block = blocks_.data() + 9 * static_cast<std::ptrdiff_t>(begin);
  Eigen::Vector4f sum[3] = {Eigen::Vector4f::Zero(), Eigen::Vector4f::Zero(), Eigen::Vector4f::Zero()};
  for (Index e = begin; e != end; e += step, block += 9 * step) {
    const Eigen::Vector4f& at = x[column_[e]];
    for (int k = 0; k < 3; ++k) sum[k] += Eigen::Map<const Eigen::Vector4f>(block + 3 * k) * at[k];
  }
  return b[row] - (sum[0] + sum[1] + sum[2]);
}

template <int step>
PHYMUL_INLINE void BlockMatrix::relax(Index row, const PaddedVectors& b, PaddedVectors& x) const {
  if (row >= 0 && row < rows()) x[row] += product(inverse_[row], residual<step>(row, b, x));
}

// The second sweep follows the first as closely as rows allow that need it done: their blocks are still in the cache.

void BlockMatrix::rise(const PaddedVectors& b, PaddedVectors& x, PaddedVectors& r) const {
  for (Index row = 0; row < rows() + 2 * reach_; ++row) {
    relax<1>(row, b, x);
    relax<1>(row - reach_, b, x);
    if (row >= 2 * reach_) r[row - 2 * reach_] = residual<1>(row - 2 * reach_, b, x);
  }
}

void BlockMatrix::fall(const PaddedVectors& b, PaddedVectors& x) const {
  for (Index row = rows() - 1; row >= -reach_; --row) {
    relax<-1>(row, b, x);
    relax<-1>(row + reach_, b, x);
  }
}

}  // namespace phymul
