// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

namespace phymul {

/// Displaces a particle at x by shift + turn x (x - centre), about 1 at most.
struct RigidMotion {
  Vec3 centre{0, 0, 0};                ///< m
  Vec3 shift{0, 0, 0}, turn{0, 0, 0};  ///< of length 1 together, if lengths are in sizes of the body

  Vec3 at(const Vec3& x) const { return shift + turn.cross(x - centre); }
};

/// The rigid motions of these particles at `position`, [N] m, that displace none along an imposed coordinate: at most
/// six, linearly independent. `fixed` [N]: as LoadFrame::fixed; may be empty.
std::vector<RigidMotion> free_motions(std::span<const Index> particles, std::span<const Vec3> position,
                                      std::span<const std::uint8_t> fixed);

}  // namespace phymul
