// SPDX-License-Identifier: MIT
//
// Where a needle's shaft is, and how it bends: a beam clamped in the hub under forces across it (Euler and Bernoulli;
// the closed form of a cantilever under one force, and the sum over the forces). So there is nothing to discretise, and
// no stiffness that a step would have to resolve.
#pragma once

#include <phymul/needle.h>
#include <phymul/tool.h>

#include <cmath>

namespace phymul {

/// The unbent shaft in the world: a coordinate along it, m from the tip, and the point of the shaft that is nearest to
/// one of the world. Its line or circle continues ahead of the tip and behind the tail: a circle on either side over
/// half of what the shaft leaves of it.
class ShaftLine {
 public:
  ShaftLine(const Needle& needle, const ToolPose& pose);
  /// Straight, from a tip along a unit vector.
  ShaftLine(const Vec3& tip, const Vec3& axis) : tip_(tip), axis_(axis) {}

  double along(const Vec3& x) const;
  Vec3 place(double along) const;
  Vec3 axis(double along) const;                    ///< unit tangent there, toward the tail
  Vec3 aside(const Vec3& x) const;                  ///< m: from the nearest point of the shaft
  const Quaternion& turn() const { return turn_; }  ///< of the tool's frame
  double arc_radius() const { return arc_radius_; }
  double round() const { return round_; }  ///< m, of the whole circle; infinite: straight
  Vec3 centre() const { return tip_ + arc_radius_ * (turn_ * Vec3::UnitX()); }

 private:
  Vec3 tip_, axis_;  // at the tip
  Quaternion turn_{1, 0, 0, 0};
  double arc_radius_ = 0.0, ahead_ = 0.0, round_ = HUGE_VAL;  // m; 0: straight. m ahead of the tip where it ends
};

/// m/N: how far a force across the shaft `from` m from the tip moves its place `at` m from the tip. Places beyond the
/// hub do not move, those ahead of the tip move as it does. 0 where the needle is stiff.
double shaft_compliance(const Needle& needle, double at, double from);

/// m, in the tool's frame.
Vec3 shaft_deflection(const Needle& needle, std::span<const ShaftLoad> loads, double along);

/// Whether what is `along` m from the tip toward the hub is ahead of it by more than what forces leave open: where the
/// tip does not cut, they bring the last node to 0 but for some 1e-3 of a step's motion, either side, so that a bound
/// of 0 would be decided by rounding. A tenth of the radius is far more than that, and a part of the tip itself.
bool is_ahead_of_tip(const Needle& needle, double along);

}  // namespace phymul
