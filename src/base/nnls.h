// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace phymul {

/// The x >= 0 that minimises |A x - b|, by the active-set method of Lawson and Hanson (Solving Least Squares Problems,
/// 1974, chapter 23). A is [rows][unknowns], any shape; the answer has at most as many positive entries as A has rank.
/// Deterministic: of equally good columns the first is taken.
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace phymul
