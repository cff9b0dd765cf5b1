// SPDX-License-Identifier: MIT
//
// What joints add to the step limit, beside the eigenvalues of their matrices.
#include <gtest/gtest.h>
#include <phymul/scene.h>
#include <phymul/shapes.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "interaction/joint_set.h"

namespace phymul {
namespace {

using Matrix = Eigen::MatrixXd;

/// Largest eigenvalue of M^-1 K of springs without a rest length, along one axis.
double largest_eigenvalue(const Scene& scene, const std::vector<double>& mass) {
  const auto n = static_cast<Eigen::Index>(mass.size());
  Matrix K = Matrix::Zero(n, n);
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
      for (std::size_t k = 0; k < spring.a.particles.size(); ++k) row[spring.a.particles[k]] += spring.a.weights[k];
      for (std::size_t k = 0; k < spring.b.particles.size(); ++k) row[spring.b.particles[k]] -= spring.b.weights[k];
      K += joint.joint.stiffness * spring.share * row * row.transpose();
    }
  }
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = 1.0 / std::sqrt(mass[i]);
  return Eigen::SelfAdjointEigenSolver<Matrix>(scale.asDiagonal() * K * scale.asDiagonal()).eigenvalues().maxCoeff();
}

Anchor some_particles(std::mt19937& random, Index first, Index count) {
  std::uniform_real_distribution<double> weight(-0.5, 1.5);
  Anchor anchor;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    anchor.particles.push_back(first + (static_cast<Index>(random() % 1000) + k * 7) % (count / 3) * 3 + k);
    anchor.weights.push_back(k < 2 ? weight(random) : 1.0 - sum);
    sum += anchor.weights.back();
  }
  return anchor;
}

TEST(JointBounds, AreBoundsForWeightsOfBothSigns) {
  std::mt19937 random(5);
  Model model = make_block({0.02, 0.02, 0.01}, 2, 2, 1);
  for (double& mass : model.mass) mass = std::exp(std::uniform_real_distribution<double>(-3, 3)(random));
  for (int trial = 0; trial < 50; ++trial) {
    Scene scene(model);
    for (int k = 0; k < 3; ++k) {
      Joint joint{.stiffness = std::exp(std::uniform_real_distribution<double>(-6, 6)(random))};
      for (int spring = 0; spring < 3; ++spring) {
        joint.springs.push_back({some_particles(random, 0, 9), some_particles(random, 9, 9), 0.0});
      }
      scene.add_joint(joint);
    }
    const double bound = JointSet().bounds(scene, model.mass).stiffness;
    EXPECT_GE(bound, largest_eigenvalue(scene, model.mass) * (1.0 - 1e-12)) << trial;
  }
}

/// A patch on the world: with x = 1 alone the bound would be set by the lightest particle.
TEST(JointBounds, OfAPatchAreCloseToTheEigenvalue) {
  Model model = make_block({0.06, 0.06, 0.02}, 6, 6, 2);
  set_material(model, {.young = 1e4, .poisson = 0.3, .density = 1000});
  Scene scene(model);
  const std::vector<Index> face = model.group("z0");
  Joint joint{.stiffness = 100.0};
  for (std::size_t k = 0; k + 8 < face.size(); ++k) {
    joint.springs.push_back({at_mean({face[k], face[k + 1], face[k + 7], face[k + 8]}), at_world({0, 0, 0}), 0.0});
  }
  scene.add_joint(joint);
  const double exact = largest_eigenvalue(scene, model.mass);
  const double bound = JointSet().bounds(scene, model.mass).stiffness;
  EXPECT_GE(bound, exact * (1.0 - 1e-12));
  EXPECT_LE(bound, 1.15 * exact);
}

TEST(JointBounds, BeyondAllNumbersAreInfinite) {
  const Model model = make_block({0.02, 0.02, 0.01}, 2, 2, 1);
  for (const double stiffness : {0.0, 1e-300, 1e300, 1e308}) {
    Scene scene(model);
    const JointHandle joint = scene.add_joint({at_mean({0, 1}), at_world({0, 0, 1})}, 1.0);
    JointSet set;
    set.bounds(scene, model.mass);
    joint.set_stiffness(stiffness, 0.0);
    const double wanted = largest_eigenvalue(scene, model.mass);
    EXPECT_GE(set.bounds(scene, model.mass).stiffness, wanted * (1.0 - 1e-12)) << stiffness;
  }
}

}  // namespace
}  // namespace phymul
