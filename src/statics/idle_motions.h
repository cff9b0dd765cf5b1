// SPDX-License-Identifier: MIT
//
// Rigid motions of bodies that nothing resists and nothing drives. Without stress in the body the tangent resists none
// of them, and in the search for its rest rounding would move it along them by many times its deformation.
#pragma once

#include <phymul/bodies.h>
#include <phymul/load_frame.h>
#include <phymul/types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "rest_term.h"

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

class IdleMotions {
 public:
  /// `loose`: the bodies that have free_motions(). Keeps references.
  IdleMotions(std::span<const ConnectedBody> loose, const LoadFrame& loads, RestTerms terms)
      : loose_(loose), loads_(loads), terms_(terms) {}

  /// Those at `position`, [N] m, where the terms are linearised. `free` [3 N]: 1, or 0 where a coordinate is imposed.
  /// `residual` [3 N], N: its part along an idle motion is at most `idle`.
  void find(std::span<const Vec3> position, const Eigen::VectorXd& free, const Eigen::VectorXd& residual, double idle);
  void remove(Eigen::VectorXd& v) const;  ///< their part of v, [3 N]

 private:
  struct OfBody {
    std::span<const Index> particles;
    Eigen::MatrixXd along;  // [3 particles, motions], orthonormal
  };
  Eigen::MatrixXd unresisted(const ConnectedBody& body, std::span<const Vec3> position,
                             const Eigen::VectorXd& free) const;

  std::span<const ConnectedBody> loose_;
  const LoadFrame& loads_;
  RestTerms terms_;
  std::vector<OfBody> idle_;
};

}  // namespace phymul
