// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/virtual_coupling.h>

#include <cmath>

#include "decimal.h"

namespace phymul {
namespace {

void require(const char* what, double value, bool zero_too) {
  if (std::isfinite(value) && (value > 0.0 || (zero_too && value == 0.0))) return;
  throw Error(std::string("VirtualCoupling: expected a finite ") + what + (zero_too ? ", 0 or more" : " above 0") +
              "; got " + to_decimal(value));
}

Vec3 limited(const Vec3& v, double most) {
  const double size = v.norm();
  return size > most ? Vec3(most / size * v) : v;
}

/// The turn from one orientation to another as a vector, the shorter way.
Vec3 turn_between(const Quaternion& from, const Quaternion& to) {
  Eigen::Quaterniond turn(to * from.conjugate());
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const Eigen::AngleAxisd angle(turn);
  return angle.angle() * angle.axis();
}

bool is_finite(const ToolPose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite() && pose.velocity.allFinite() &&
         pose.spin.allFinite();
}

}  // namespace

VirtualCoupling::VirtualCoupling(const CouplingOptions& options, const ToolPose& device) : options_(options) {
  require("stiffness (N/m)", options.stiffness, true);
  require("damping (N s/m)", options.damping, true);
  require("mass (kg)", options.mass, false);
  require("turning_stiffness (N m/rad)", options.turning_stiffness, true);
  require("turning_damping (N m s/rad)", options.turning_damping, true);
  require("inertia (kg m^2)", options.inertia, false);
  require("largest_force (N)", options.largest_force, false);
  require("largest_torque (N m)", options.largest_torque, false);
  reset(device);
}

void VirtualCoupling::reset(const ToolPose& device) {
  if (!is_finite(device) || !(device.orientation.norm() > 0.0)) {
    throw Error("VirtualCoupling: expected a pose of finite numbers and an orientation that is not zero");
  }
  tool_ = device;
  tool_.orientation.normalize();
  force_ = torque_ = Vec3::Zero();
}

const ToolPose& VirtualCoupling::follow(const ToolPose& device, const Vec3& force_on_tool, const Vec3& torque_on_tool,
                                        double dt) {
  if (!(dt >= 0.0)) return tool_;
  // m (v+ - v) / dt = k (x_device - x - dt v+) + b (v_device - v+) + F, solved for v+; the same for turning.
  const CouplingOptions& o = options_;
  ToolPose next = tool_;
  const Vec3 pull = o.stiffness * (device.position - tool_.position) + o.damping * device.velocity + force_on_tool;
  next.velocity = (o.mass * tool_.velocity + dt * pull) / (o.mass + dt * o.damping + dt * dt * o.stiffness);
  next.position += dt * next.velocity;
  const Vec3 twist = o.turning_stiffness * turn_between(tool_.orientation, device.orientation) +
                     o.turning_damping * device.spin + torque_on_tool;
  next.spin =
      (o.inertia * tool_.spin + dt * twist) / (o.inertia + dt * o.turning_damping + dt * dt * o.turning_stiffness);
  const double angle = dt * next.spin.norm();
  if (angle > 0.0) {
    const Quaternion turn(Eigen::Quaterniond(Eigen::AngleAxisd(angle, next.spin.normalized())));
    next.orientation = (turn * tool_.orientation).normalized();
  }
  const Vec3 force = o.stiffness * (next.position - device.position) + o.damping * (next.velocity - device.velocity);
  const Vec3 torque = o.turning_stiffness * turn_between(device.orientation, next.orientation) +
                      o.turning_damping * (next.spin - device.spin);
  // Not only what came is looked at: finite numbers can be too large for what is computed from them, and one that is
  // not finite would stay in the tool's pose for good. The squares of the lengths are what overflows first.
  const double sizes = force.squaredNorm() + torque.squaredNorm();
  if (!is_finite(next) || !is_finite(device) || !std::isfinite(sizes)) return tool_;
  tool_ = next;
  force_ = limited(force, o.largest_force);
  torque_ = limited(torque, o.largest_torque);
  return tool_;
}

}  // namespace phymul
