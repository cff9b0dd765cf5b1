// SPDX-License-Identifier: MIT
//
// Joints in the fast backend: their forces, in double precision, are added to the loads that the moving kernel reads.
#pragma once

#include <phymul/topology_textures.h>

#include "interaction/stiff_joints.h"
#include "interaction/tool_set.h"
#include "packed_body.h"

namespace phymul::cpu {

class PackedJoints {
 public:
  /// After a change of the scene. `stiff`: SolverBackend::stiff_joints(). Empties what it does not need.
  void follow(JointSet& joints, StiffJoints* stiff, const ToolSet& tools, const PackedBody& body);

  /// Before a moving pass of dt, s, if there are joints: adds their forces to move.load, in an array of its own.
  /// `changed`: null, or marks for blocks of particles (sleep_blocks.h) whose forces are not those of the last call.
  void act(JointSet& joints, ToolSet& tools, const TopologyTextures& topology, double dt, simd::Move& move,
           std::uint8_t* changed);

  /// Adds to load_ what the implicit joints change of the forces in `force`, [places][4] N by quad, and the loads of
  /// `move`.
  void solve(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d, const char* force,
             simd::Move& move);
  /// The same of what tools have added to move.load, to `loads`, which have both.
  void solve_pushes(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
                    const simd::Move& move, char* loads);

 private:
  struct At {
    std::size_t quad;                     // of displacements and loads
    std::array<std::size_t, 3> velocity;  // rows of it
    std::array<float, 3> force{};         // N, of the last call
  };
  struct Place {
    std::size_t quad, place;
  };
  template <class Acceleration>
  void solve(StiffJoints& stiff, const JointSet& joints, const Scene& scene, double dt, double d,
             const simd::Move& move, const Acceleration& acceleration, bool later, char* loads);

  std::vector<At> at_;          // by JointSet::points()
  std::vector<Place> reached_;  // by StiffJoints::reached()
  std::vector<ToolWay> ways_;
  Floats load_;  // [places][4] by quad, N; empty without joints
};

}  // namespace phymul::cpu
