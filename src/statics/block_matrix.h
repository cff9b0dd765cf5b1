// SPDX-License-Identifier: MIT
//
// A symmetric sparse matrix of 3 x 3 blocks by rows, in single precision, for the smoothing on coarse levels of
// statics.
#pragma once

#include <phymul/types.h>

#include <vector>

#include "padded_vectors.h"

namespace phymul {

class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// `columns` [rows]: of each row, sorted, the diagonal among them.
  explicit BlockMatrix(const std::vector<std::vector<Index>>& columns);

  Index rows() const { return static_cast<Index>(first_.size()) - 1; }
  void set_zero();
  Index entry(Index row, Index column) const;
  PaddedMatrix& at(Index entry) { return blocks_[entry]; }

  void invert_diagonal();  ///< after the last change, before smooth()
  /// result = b - A x. Shapes [rows].
  void residual(const PaddedVectors& b, const PaddedVectors& x, PaddedVectors& result) const;
  /// One sweep of Gauss and Seidel over x for A x = b, by rising rows or by falling ones.
  void smooth(const PaddedVectors& b, bool rising, PaddedVectors& x) const;

 private:
  Eigen::Vector4f row_residual(Index row, const PaddedVectors& b, const PaddedVectors& x) const;

  std::vector<Index> first_{0}, column_;
  std::vector<PaddedMatrix> blocks_, inverse_;
};

}  // namespace phymul
