// SPDX-License-Identifier: MIT
//
// Joints in the fast backend: their forces, in double precision, are added to the loads that the moving kernel reads.
#pragma once

#include <phymul/topology_textures.h>

#include "interaction/tool_set.h"
#include "packed_body.h"

namespace phymul::cpu {

class PackedJoints {
 public:
  /// After a change of the scene. Empties what it does not need.
  void follow(JointSet& joints, const ToolSet& tools, const PackedBody& body);

  /// Before a moving pass of dt, s, if there are joints: adds their forces to move.load, in an array of its own.
  /// `changed`: null, or marks for blocks of particles (sleep_blocks.h) whose forces are not those of the last call.
  void act(JointSet& joints, ToolSet& tools, const TopologyTextures& topology, double dt, simd::Move& move,
           std::uint8_t* changed);

 private:
  struct At {
    std::size_t quad;                     // of displacements and loads
    std::array<std::size_t, 3> velocity;  // rows of it
    std::array<float, 3> force{};         // N, of the last call
  };
  std::vector<At> at_;  // by JointSet::points()
  std::vector<ToolWay> ways_;
  Floats load_;  // [places][4] by quad, N; empty without joints
};

}  // namespace phymul::cpu
