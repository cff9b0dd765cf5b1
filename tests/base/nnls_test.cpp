// SPDX-License-Identifier: MIT
#include "base/nnls.h"

#include <gtest/gtest.h>

#include <random>

namespace phymul {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The conditions that make x the answer: x >= 0, no column with x = 0 lowers the residual, none with x > 0 changes it.
void expect_optimal(const MatrixXd& a, const VectorXd& b, const VectorXd& x) {
  ASSERT_EQ(x.size(), a.cols());
  const VectorXd gradient = a.transpose() * (b - a * x);
  const double scale = a.norm() * b.norm();
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    EXPECT_GE(x[j], 0.0);
    EXPECT_LE(gradient[j], 1e-10 * scale) << j;
    if (x[j] > 0.0) {
      EXPECT_NEAR(gradient[j], 0.0, 1e-10 * scale) << j;
    }
  }
}

TEST(Nnls, BoundThatDoesNotBindLeavesLeastSquares) {
  MatrixXd a(3, 2);
  a << 1, 0, 0, 2, 0, 0;
  const VectorXd x = non_negative_least_squares(a, Eigen::Vector3d(3, 4, 5));
  EXPECT_NEAR(x[0], 3.0, 1e-14);
  EXPECT_NEAR(x[1], 2.0, 1e-14);
}

TEST(Nnls, BindingBoundChangesTheOthers) {
  MatrixXd a(2, 2);
  a << 1, 1, 0, 1;
  // Unbounded: (2, -1). With x1 held at 0 the first column alone gives 1.
  const VectorXd x = non_negative_least_squares(a, Eigen::Vector2d(1, -1));
  EXPECT_NEAR(x[0], 1.0, 1e-14);
  EXPECT_EQ(x[1], 0.0);
}

TEST(Nnls, NothingHelps) {
  const VectorXd x = non_negative_least_squares(MatrixXd::Identity(3, 3), Eigen::Vector3d(-1, -2, 0));
  EXPECT_EQ(x, VectorXd::Zero(3));
  EXPECT_EQ(non_negative_least_squares(MatrixXd(3, 0), Eigen::Vector3d(1, 1, 1)).size(), 0);
  EXPECT_EQ(non_negative_least_squares(MatrixXd::Zero(2, 2), Eigen::Vector2d(1, 1)), VectorXd::Zero(2));
}

TEST(Nnls, EntryThatLeavesAgain) {
  // The first column is the steepest at the start and is not in the answer.
  MatrixXd a(3, 3);
  a << 0.70, 1.0, 0.0,  //
      0.70, 0.0, 1.0,   //
      0.15, 0.0, 0.0;
  const VectorXd b = Eigen::Vector3d(1, 1, -0.5);
  const VectorXd x = non_negative_least_squares(a, b);
  expect_optimal(a, b, x);
  EXPECT_EQ(x[0], 0.0);
  EXPECT_NEAR(x[1], 1.0, 1e-12);
}

TEST(Nnls, RandomProblemsOfEveryShapeAreOptimal) {
  std::mt19937 bits(3);
  const auto draw = [&bits] { return static_cast<double>(bits()) / 2147483648.0 - 1.0; };
  for (int rows : {3, 8, 19}) {
    for (int columns : {1, 5, 19, 120}) {
      for (int trial = 0; trial < 5; ++trial) {
        MatrixXd a(rows, columns);
        VectorXd b(rows);
        for (double& entry : a.reshaped()) entry = draw();
        for (double& entry : b) entry = draw();
        if (trial == 4 && columns > 4) a.col(3) = a.col(1);  // equal columns
        const VectorXd x = non_negative_least_squares(a, b);
        expect_optimal(a, b, x);
        EXPECT_LE((x.array() > 0.0).count(), rows);
      }
    }
  }
}

TEST(Nnls, AnswerScalesWithTheProblem) {
  MatrixXd a(3, 4);
  a << 1, 2, 0, 1, 0, 1, 3, 1, 2, 0, 1, 1;
  const VectorXd b = Eigen::Vector3d(1, 2, 1);
  const VectorXd x = non_negative_least_squares(a, b);
  EXPECT_LT((non_negative_least_squares(a * 1e-9, b * 1e-9) - x).norm(), 1e-12);
  EXPECT_LT((non_negative_least_squares(a, b * 1e12) - 1e12 * x).norm(), 1.0);
}

}  // namespace
}  // namespace phymul
