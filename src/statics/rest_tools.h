// SPDX-License-Identifier: MIT
//
// Joints, and tools without friction, as statics knows them. A point of the surface (interaction/contact_points.h) at
// the signed distance phi from a tool bears the force f >= 0 along the normal, with
//   f = 0 where phi > 0, else phi = -c f,   c: Tool::compliance.
// The law is approached by augmented Lagrangians: f = max(0, (s - k phi) / (1 + k c)) with a stiffness k, and raise()
// takes f as the next s. The points of a triangle share a force in many ways, between which raise() would go on
// choosing: with ToolContact::surface a few times are enough, after which some points are still inside by less than a
// thousandth of the body's indentation. Source: J. Nocedal and S. Wright, Numerical Optimization, ch. 17.
//
// What a box presses at its edges lies between such points. So over its triangles the energy is an integral without s,
// of 1/2 k phi^2 (integrate_depth), whose k raise() multiplies.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <cstdint>
#include <string>
#include <vector>

#include "interaction/contact_points.h"
#include "interaction/distance_to_shape.h"
#include "interaction/tool_frame.h"
#include "rest_term.h"

namespace phymul {

class RestTools final : public RestTerm {
 public:
  /// Tools at their last target poses. `stiffness` [N] N/m: of each particle in its neighbourhood. `fixed`: as
  /// LoadFrame::fixed, what tools hold included; tools do not press what cannot move. Must not outlive the scene.
  RestTools(const Scene& scene, std::span<const Mat3> stiffness, std::span<const std::uint8_t> fixed);
  /// Moves the tools to their target poses now and keeps what was estimated. False if others are needed for this scene,
  /// of the same body.
  bool follow(const Scene& scene);

  void mark_held(std::span<char> particles) const override;
  void add_forces(std::span<const Vec3> position, std::span<Vec3> force) const override;
  double energy(std::span<const Vec3> position) const override;
  double squared_support(std::span<const Vec3> position) const override;
  void linearise(std::span<const Vec3> position) override;
  void add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const override;
  void add_diagonal(std::span<Mat3> blocks) const override;
  double squared_miss(std::span<const Vec3> position) const override;
  void raise(std::span<const Vec3> position) override;
  void append_estimates(std::vector<double>& all) const override;
  std::span<const double> take_estimates(std::span<const double> all) override;

  /// Adds what the particles that they press do to the tools, [Scene::tools()].
  void add_reactions(std::span<const Vec3> position, std::span<ToolForce> all) const;

 private:
  struct Touching {
    Tool tool;  // but for its pose
    ContactPoints points;
    ShapeIn<double> shape;
    ToolFrame frame;
    int raises_left;
    std::vector<double> stiffness;  // N/m, k of all points, by patches
    std::vector<double> estimate;   // N, likewise s
    double raised = 1.0;            // factor of k in the integrals over triangles
    bool integrates(const ContactPoints::Patch& patch) const;
  };
  struct Pressed {  // a point that bears a force
    const ContactPoints::Patch* patch;
    ContactPoints::Shares share;
    std::size_t row;     // in its tool's vectors, no_row: of an integral
    double force, gain;  // N and N/m: f and -df/dphi
    Vec3 normal;         // out of the tool
    Vec3 stiff;          // along it the force changes
  };
  static constexpr std::size_t no_row = static_cast<std::size_t>(-1);
  template <class Visit>
  static void for_each_pressed(const Touching& tool, std::span<const Vec3> position, const Visit& visit);
  VecList forces_of(const Touching& tool, std::span<const Vec3> position) const;

  std::size_t particles_;
  std::vector<Touching> tools_;
  std::vector<Pressed> linear_;  // as of the last linearise()
  int linearised_ = 0;           // since the first search began, or raise()
};

/// The joints of a scene as statics knows them: springs of known forces and stiffness.
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
