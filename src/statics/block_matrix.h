// SPDX-License-Identifier: MIT
//
// A symmetric sparse matrix of 3 x 3 blocks by rows, for the coarse levels of statics.
#pragma once

#include <phymul/types.h>

#include <Eigen/Core>
#include <span>
#include <vector>

namespace phymul {

class BlockMatrix {
 public:
  /// `columns` [rows]: of each row, sorted, the diagonal among them.
  explicit BlockMatrix(const std::vector<std::vector<Index>>& columns);

  Index rows() const { return static_cast<Index>(first_.size()) - 1; }
  void set_zero();
  Index entry(Index row, Index column) const;
  Mat3& at(Index entry) { return blocks_[entry]; }
  const Mat3& at(Index entry) const { return blocks_[entry]; }
  std::span<const Index> columns_of(Index row) const {
    return {column_.data() + first_[row], column_.data() + first_[row + 1]};
  }

  void invert_diagonal();  ///< after the last change, before smooth()
  /// result = b - A x. Shapes [3 rows].
  void residual(const Eigen::VectorXd& b, const Eigen::VectorXd& x, Eigen::VectorXd& result) const;
  /// One sweep of Gauss and Seidel over x for A x = b, by rising rows or by falling ones.
  void smooth(const Eigen::VectorXd& b, bool rising, Eigen::VectorXd& x) const;

 private:
  Vec3 row_product(Index row, const Eigen::VectorXd& x) const;

  std::vector<Index> first_{0}, column_, diagonal_;
  std::vector<Mat3> blocks_, inverse_;
};

}  // namespace phymul
