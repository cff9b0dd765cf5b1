// SPDX-License-Identifier: MIT
#include "needle_weights.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace phymul {
namespace {

/// Least over largest eigenvalue of the moments below which particles lie in a plane, or all but.
constexpr double flattest = 1e-4;

}  // namespace

NeedleNode spread_weights(const PredictedStep& step, std::span<const Index> around, const Vec3& x,
                          double support_radius) {
  NeedleNode node;
  std::vector<Eigen::Vector4d> basis;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (const Index i : around) {
    const Vec3 d = (step.position(i) - x) / support_radius;
    const double inside = 1.0 - d.squaredNorm();
    if (!(inside > 0.0)) continue;
    node.particles.push_back(i);
    node.weights.push_back(inside * inside);
    basis.emplace_back(1.0, d.x(), d.y(), d.z());
    moments += node.weights.back() * basis.back() * basis.back().transpose();
  }
  // In two steps, without eigenvectors: the constructor that does both takes far longer to compile.
  const Eigen::Tridiagonalization<Eigen::Matrix4d> tridiagonal(moments);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> spectrum;
  spectrum.computeFromTridiagonal(tridiagonal.diagonal(), tridiagonal.subDiagonal(), Eigen::EigenvaluesOnly);
  const bool spans = node.particles.size() >= 4 && spectrum.eigenvalues()[0] > flattest * spectrum.eigenvalues()[3];
  if (!spans) return {};
  const Eigen::Vector4d coefficients = moments.ldlt().solve(Eigen::Vector4d::UnitX());
  for (std::size_t k = 0; k < basis.size(); ++k) node.weights[k] *= coefficients.dot(basis[k]);
  return node;
}

}  // namespace phymul
