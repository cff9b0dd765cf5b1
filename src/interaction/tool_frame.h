// SPDX-License-Identifier: MIT
//
// A tool's frame at one instant, and the reaction on it.
#pragma once

#include <phymul/tool.h>

#include "base/vector3.h"

namespace phymul {

/// Why a step is undone after which a tool has no such pose.
inline constexpr const char* pose_not_finite =
    "the pose of a tool, or a force on it, would not be finite: where it goes is extremely far away";

inline bool is_finite(const ToolPose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite() && pose.velocity.allFinite() &&
         pose.spin.allFinite();
}

inline Vector3<double> unpacked(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
inline Vec3 packed(const Vector3<double>& v) {
  return {v.x, v.y, v.z};
}

struct ToolFrame {
  explicit ToolFrame(const ToolPose& pose) : turn(pose.orientation.toRotationMatrix()), position(pose.position) {}
  Vec3 inside(const Vec3& x) const { return turn.transpose() * (x - position); }
  Vec3 outside(const Vec3& q) const { return position + turn * q; }
  Mat3 turn;
  Vec3 position;
};

/// The particle's impulse, turned round, on the tool. The arm goes to where the particle was at the step's start: with
/// it Verlet's angular momentum x cross m v changes by exactly what the tool gives.
inline void react(ToolForce& force, const ToolFrame& end, const Vec3& at, const Vec3& impulse, double dt) {
  force.force -= impulse / dt;
  force.torque -= (at - end.position).cross(impulse) / dt;
  ++force.particles;
}

}  // namespace phymul
