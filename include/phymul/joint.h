// SPDX-License-Identifier: MIT
//
// Joints: springs with dampers between particles and the world, tools or other particles: ligaments, sutures, glue,
// ties. Scene::add_joint and Scene::attach add them.
//
// A spring joins two anchors, r apart (from `a` to `b`). With a rest length L above 0 the force on anchor `a` is
//   f = (k (|r| - L) + c d|r|/dt) r / |r|,
// along the line between the anchors; 0 if r = 0. With L = 0 it is f = k r + c dr/dt, in any direction. Anchor `b` gets
// -f. Forces are those of the state at a step's start, so they limit the step (Solver::stable_step()). They conserve
// linear momentum, and angular momentum except for the damper of a spring with L = 0, whose force is not along r.
#pragma once

#include <phymul/types.h>

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace phymul {

/// Where a spring ends: a weighted mean of particles, a fixed point of the world, or a point that moves with a tool.
/// The force is shared among the particles by the weights. A force on one particle alone makes a dimple that depends on
/// the mesh: use several particles.
struct Anchor {
  std::vector<Index> particles{};  ///< [P] rows of the model, each once; empty: a point of the world or of a tool
  std::vector<double> weights{};   ///< [P], of sum 1
  std::string tool{};              ///< name of a tool of the scene; empty: none
  Vec3 point{0, 0, 0};             ///< m, without particles: in the world, or in the tool's frame
  bool operator==(const Anchor&) const = default;
};

Anchor at_particle(Index particle);
Anchor at_mean(std::vector<Index> particles);                     ///< with equal weights; throws Error for none
Anchor at_world(const Vec3& point);                               ///< m
Anchor at_tool(std::string tool, const Vec3& point = {0, 0, 0});  ///< m, in its frame; throws Error for an empty name

struct JointSpring {
  Anchor a{}, b{};            ///< at least one of them has particles
  double rest_length = -1.0;  ///< m; below 0: the distance when the joint is added
  double share = 1.0;         ///< > 0: factor of the joint's stiffness, damping and breaking force; an area, m^2, if
                              ///< these are per area
  bool operator==(const JointSpring&) const = default;
};

/// Springs with common constants: one spring or a whole patch. The constants hold for a spring of share 1.
struct Joint {
  std::vector<JointSpring> springs{};
  double stiffness = 0.0;  ///< N/m, >= 0
  double damping = 0.0;    ///< N s/m, >= 0
  bool slack = false;      ///< pulls only, as a ligament or a thread does, its damper too
  /// N, > 0. A spring whose force is larger in some step has no force from the next step on.
  double breaking_force = std::numeric_limits<double>::infinity();
  bool operator==(const Joint&) const = default;
};

/// Part of a Scene.
struct SceneJoint {
  std::uint64_t id = 0;  ///< unique in its scene, also after joints were removed
  std::string name{};
  Joint joint{};  ///< rest lengths are not negative
};

/// Partner of Scene::attach: each spring ends at a fixed point, at this offset, m, from the position of its particle.
/// With offset zero the rest length is 0, and the spring resists displacements in all directions. Otherwise the rest
/// length is that of the offset: parallel fibres.
struct World {
  Vec3 offset{0, 0, 0};
};

/// Springs per area, for Scene::attach. A layer of thickness t and Young's modulus E has the stiffness E / t.
struct Attachment {
  double stiffness = 0.0;                                            ///< N/m per m^2: N/m^3, >= 0
  double damping = 0.0;                                              ///< N s/m^3, >= 0
  double breaking_stress = std::numeric_limits<double>::infinity();  ///< Pa, > 0
  bool slack = false;                                                ///< as Joint::slack
  std::span<const Vec3> position{};  ///< [N] m, where the particles are: State::position; empty: at rest
  std::string name{};                ///< empty: "joint 1", "joint 2" and so on
};

struct SpringReport {
  Vec3 force{0, 0, 0};  ///< N, on anchor `a`; still not 0 in the step in which it breaks
  double length = 0.0;  ///< m, between the anchors
  bool broken = false;  ///< the force is 0 from the next step on
  bool operator==(const SpringReport&) const = default;
};

/// A joint in the last step of a solver: forces and lengths are those at the step's start; of a joint that is solved
/// implicitly (SolverOptions::max_substeps) forces are the means over the step. Before the first step all are 0.
struct JointReport {
  Vec3 force{0, 0, 0};   ///< N, sum over the springs of the force on anchors `a`
  double largest = 0.0;  ///< N, largest force of a spring
  int broken = 0;        ///< number of broken springs
  std::vector<SpringReport> springs{};
  bool operator==(const JointReport&) const = default;
};

/// Part of a State: the broken springs of a joint.
struct JointState {
  std::string name{};
  std::vector<Index> broken{};  ///< rows of Joint::springs, increasing
  bool operator==(const JointState&) const = default;
};

}  // namespace phymul
