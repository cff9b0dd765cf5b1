// SPDX-License-Identifier: MIT
//
// The law of a joint's spring (include/phymul/joint.h).
#pragma once

#include <phymul/joint.h>

#include <algorithm>
#include <span>

namespace phymul {

/// Whether it ends at a particle all of whose tissue is removed: such a spring is broken. `mass`: of all particles.
inline bool ends_at_removed(const JointSpring& spring, std::span<const double> mass) {
  const auto removed = [&](Index i) { return mass[i] == 0.0; };
  return std::ranges::any_of(spring.a.particles, removed) || std::ranges::any_of(spring.b.particles, removed);
}

/// N, on anchor `a`, where `r` leads to `b`, m, and `v` is how it changes, m/s.
inline Vec3 spring_force(const Joint& joint, const JointSpring& spring, const Vec3& r, const Vec3& v) {
  const double k = spring.share * joint.stiffness, c = spring.share * joint.damping;
  if (spring.rest_length == 0.0) {
    const Vec3 force = k * r + c * v;
    return joint.slack && force.dot(r) < 0.0 ? Vec3(Vec3::Zero()) : force;
  }
  const double length = r.norm();
  // In one point the spring has no direction.
  if (length == 0.0 || (joint.slack && length <= spring.rest_length)) return Vec3::Zero();
  const Vec3 direction = r / length;
  const double pull = k * (length - spring.rest_length) + c * v.dot(direction);
  return joint.slack && pull < 0.0 ? Vec3(Vec3::Zero()) : Vec3(pull * direction);
}

/// J.
inline double spring_energy(const Joint& joint, const JointSpring& spring, double length) {
  const double stretch = length - spring.rest_length;
  if (joint.slack && stretch < 0.0) return 0.0;
  return 0.5 * spring.share * joint.stiffness * stretch * stretch;
}

/// N/m: how the force on anchor `a` grows with r, without what a compressed spring takes from the stiffness sideways,
/// so that no eigenvalue is below 0.
inline Mat3 spring_tangent(const Joint& joint, const JointSpring& spring, const Vec3& r) {
  const double k = spring.share * joint.stiffness, length = r.norm();
  if (spring.rest_length == 0.0) return k * Mat3::Identity();
  if (length == 0.0 || (joint.slack && length <= spring.rest_length)) return Mat3::Zero();
  const Mat3 along = r * r.transpose() / (length * length);
  const double tension = length > spring.rest_length ? 1.0 - spring.rest_length / length : 0.0;
  return k * (along + tension * (Mat3::Identity() - along));
}

}  // namespace phymul
