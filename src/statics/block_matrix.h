// SPDX-License-Identifier: MIT
//
// A symmetric sparse matrix of 3 x 3 blocks by rows, in single precision, for the smoothing on coarse levels of
// statics.
#pragma once

#include <phymul/types.h>

#include <Eigen/Core>
#include <span>
#include <vector>

#include "base/compiler.h"

namespace phymul {

// Vectors and matrices of three rows in single precision, with a fourth row of zeros: four numbers at a time are what
// every processor adds in one go. Preconditioners and local time steps need no more than that.

using PaddedVectors = std::vector<Eigen::Vector4f>;
using PaddedMatrix = Eigen::Matrix<float, 4, 3>;

inline PaddedMatrix padded(const Eigen::Matrix3d& A) {
  PaddedMatrix result = PaddedMatrix::Zero();
  result.topRows<3>() = A.cast<float>();
  return result;
}

PHYMUL_INLINE Eigen::Vector4f product(const PaddedMatrix& A, const Eigen::Vector4f& x) {
  return A.col(0) * x[0] + A.col(1) * x[1] + A.col(2) * x[2];
}

/// The vectors of `numbers`, [4 n].
inline std::span<const Eigen::Vector4f> vectors_of(const Eigen::VectorXf& numbers) {
  return {reinterpret_cast<const Eigen::Vector4f*>(numbers.data()), static_cast<std::size_t>(numbers.size()) / 4};
}
inline std::span<Eigen::Vector4f> vectors_of(Eigen::VectorXf& numbers) {
  return {reinterpret_cast<Eigen::Vector4f*>(numbers.data()), static_cast<std::size_t>(numbers.size()) / 4};
}

/// All numbers of `v`, [4 n].
inline Eigen::Map<Eigen::VectorXf, Eigen::Aligned16> numbers_of(PaddedVectors& v) {
  return {v.data()->data(), 4 * static_cast<Eigen::Index>(v.size())};
}

class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// `first` [rows + 1] of each row's entries in `column`; those of a row are sorted, and the diagonal is among them.
  BlockMatrix(std::vector<Index> first, std::vector<Index> column);

  Index rows() const { return static_cast<Index>(first_.size()) - 1; }
  void set_zero();
  Eigen::Map<Eigen::Matrix3f> at(Index entry) {
    return Eigen::Map<Eigen::Matrix3f>(&blocks_[9 * static_cast<std::size_t>(entry)]);
  }

  void invert_diagonal();  ///< after the last change, before rise() and fall()
  /// Two sweeps of Gauss and Seidel over x for A x = b by rising rows, then the residual r = b - A x. Shapes [rows].
  void rise(const PaddedVectors& b, PaddedVectors& x, PaddedVectors& r) const;
  /// Two by falling rows.
  void fall(const PaddedVectors& b, PaddedVectors& x) const;

 private:
  template <int step>
  Eigen::Vector4f residual(Index row, const PaddedVectors& b, const PaddedVectors& x) const;
  template <int step>
  void relax(Index row, const PaddedVectors& b, PaddedVectors& x) const;

  std::vector<Index> first_{0}, column_, diagonal_;
  Index reach_ = 0;            // beyond which no row has an entry
  std::vector<float> blocks_;  // 9 of each entry by columns, and one more: columns are read by fours
  std::vector<PaddedMatrix> inverse_;
};

}  // namespace phymul
