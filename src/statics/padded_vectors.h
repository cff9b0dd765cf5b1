// SPDX-License-Identifier: MIT
//
// Vectors and matrices of three rows in single precision, with a fourth row of zeros: four numbers at a time are what
// every processor adds in one go. Preconditioners and local time steps need no more than that.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "base/compiler.h"

namespace phymul {

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

}  // namespace phymul
