// SPDX-License-Identifier: MIT
#include "packed_joints.h"

#include <cstring>

#include "sleep_blocks.h"

namespace phymul::cpu {

void PackedJoints::follow(JointSet& joints, const ToolSet& tools, const PackedBody& body) {
  at_.clear();
  load_.clear();
  if (joints.empty()) return;
  std::vector<std::size_t> place_of(body.order.size());
  for (std::size_t place = 0; place < place_of.size(); ++place) place_of[body.order[place]] = place;
  const auto lanes = static_cast<std::size_t>(body.lanes);
  for (const JointSet::Point& point : joints.points()) {
    const std::size_t place = place_of[point.particle];
    At& at = at_.emplace_back();
    at.quad = body.quad_of(place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at.velocity[axis] = (3 * (place / lanes) + axis) * lanes + place % lanes;
    }
  }
  ways_.reserve(tools.count());
  load_.assign(4 * static_cast<std::size_t>(body.places), 0.0f);
}

void PackedJoints::act(JointSet& joints, ToolSet& tools, const TopologyTextures& topology, double dt, simd::Move& move,
                       std::uint8_t* changed) {
  const auto* const u = reinterpret_cast<const float*>(move.u);
  for (std::size_t row = 0; row < at_.size(); ++row) {
    const At& at = at_[row];
    JointSet::Point& point = joints.points()[row];
    const float* const own = u + 4 * at.quad;
    point.position = topology.rest[point.particle] + Vec3(own[0], own[1], own[2]);
    point.velocity = Vec3(move.v[at.velocity[0]], move.v[at.velocity[1]], move.v[at.velocity[2]]);
  }
  tools.ways(dt, ways_);
  joints.act(ways_, dt);
  tools.pull(joints.pulls());

  if (move.load != nullptr) std::memcpy(load_.data(), move.load, sizeof(float) * load_.size());
  for (std::size_t row = 0; row < at_.size(); ++row) {
    At& at = at_[row];
    float* const load = &load_[4 * at.quad];
    const Eigen::Vector3f force = joints.points()[row].force.cast<float>();
    for (int a = 0; a < 3; ++a) {
      if (changed != nullptr && force[a] != at.force[a]) changed[SleepBlocks::of_quad(at.quad)] = 1;
      at.force[a] = force[a];
      load[a] = (move.load != nullptr ? load[a] : 0.0f) + force[a];
    }
  }
  move.load = reinterpret_cast<const char*>(load_.data());
}

}  // namespace phymul::cpu
