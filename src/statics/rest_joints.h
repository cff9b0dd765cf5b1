// SPDX-License-Identifier: MIT
//
// The joints of a scene without tools as statics knows them: springs of known forces and stiffness.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace phymul {

class RestJoints {
 public:
  /// All springs but those that are broken in `state`. Keeps a reference to the scene.
  RestJoints(const Scene& scene, const State& state);

  bool empty() const { return springs_.empty(); }
  std::vector<char> joined() const;  ///< [N] 1: an end of a spring
  /// Adds forces at positions [N], m, to `force` [N], N.
  void add_forces(std::span<const Vec3> position, std::span<Vec3> force) const;
  double energy(std::span<const Vec3> position) const;  ///< J
  /// N^2: the sum of squares of the forces on points of the world.
  double squared_support(std::span<const Vec3> position) const;

  void linearise(std::span<const Vec3> position);
  /// result += K d, [3 N] N and m, K as of the last linearise().
  void add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const;
  /// [N] N/m: blocks of the diagonal of that K; none without joints.
  std::vector<Mat3> diagonal() const;

  /// The name of a joint one of whose springs is loaded beyond what breaks it; empty: none is.
  std::string overloaded(std::span<const Vec3> position) const;

 private:
  struct Spring {
    const SceneJoint* joint;
    const JointSpring* spring;
    Mat3 tangent = Mat3::Zero();
  };
  Vec3 span_of(const JointSpring& spring, std::span<const Vec3> position) const;

  const Scene& scene_;
  std::size_t particles_;
  std::vector<Spring> springs_;
};

}  // namespace phymul
