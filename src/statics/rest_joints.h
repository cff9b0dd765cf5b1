// SPDX-License-Identifier: MIT
//
// The joints of a scene as statics knows them: springs of known forces and stiffness.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <string>
#include <vector>

#include "rest_term.h"

namespace phymul {

class RestJoints final : public RestTerm {
 public:
  /// All springs but those that are broken in `state`. Keeps a reference to the scene.
  RestJoints(const Scene& scene, const State& state);

  bool empty() const { return springs_.empty(); }
  void mark_held(std::span<char> particles) const override;
  void add_forces(std::span<const Vec3> position, std::span<Vec3> force) const override;
  double energy(std::span<const Vec3> position) const override;
  double squared_support(std::span<const Vec3> position) const override;
  void linearise(std::span<const Vec3> position) override;
  void add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const override;
  void add_diagonal(std::span<Mat3> blocks) const override;

  /// Adds what springs do to the tools, [Scene::tools()].
  void add_reactions(std::span<const Vec3> position, std::span<ToolForce> tools) const;
  /// By Scene::joints().
  std::vector<JointReport> reports(std::span<const Vec3> position) const;
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
  std::vector<Spring> springs_;
};

}  // namespace phymul
