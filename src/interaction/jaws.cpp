// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/jaws.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/decimal.h"

namespace phymul {
namespace {

/// Of the plate on each side of the hinge's plane y = 0.
constexpr std::array<double, 2> side_of{1.0, -1.0};

void require(bool sound, const char* what, double got) {
  if (!sound || !std::isfinite(got)) throw Error("Jaws: expected " + std::string(what) + ", got " + to_decimal(got));
}

void require(const JawsOptions& options) {
  require(options.length > 0.0, "a length (m) above 0", options.length);
  require(options.width > 0.0, "a width (m) above 0", options.width);
  require(options.thickness > 0.0, "a thickness (m) above 0", options.thickness);
  require(options.grip > 0.0, "a grip (N) above 0", options.grip);
  require(options.opening > 0.0 && options.opening <= 3.0, "an opening above 0 and of at most 3 rad", options.opening);
  require(options.speed > 0.0, "a speed (rad/s) above 0", options.speed);
  if (options.toughness) require(*options.toughness >= 0.0, "a toughness (J/m^2) of 0 or more", *options.toughness);
}

/// From a tool's axes to those of its plate: a blade has its edge along z and cuts toward the other one.
Eigen::Quaterniond axes_of(const JawsOptions& options, std::size_t side) {
  if (!options.toughness) return Eigen::Quaterniond::Identity();
  Mat3 axes;
  axes << 0, side_of[side], 0, 0, 0, side_of[side], 1, 0, 0;
  return Eigen::Quaterniond(axes);
}

/// m, from the hinge to the middle of a plate at the angle 0, in the plate's axes.
Vec3 middle_of(const JawsOptions& options, std::size_t side) {
  return {0.0, options.toughness ? 0.0 : 0.5 * side_of[side] * options.thickness, -0.5 * options.length};
}

/// The plate of the side that lies on the plane y = 0, turned about the hinge by half of the angle.
ToolPose plate_at(const JawsOptions& options, const ToolPose& hinge, std::size_t side, double angle) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * side_of[side] * angle, Vec3::UnitX()));
  const Eigen::Quaterniond frame(hinge.orientation.normalized());
  ToolPose pose = hinge;
  pose.orientation = Quaternion(frame * turn * axes_of(options, side));
  pose.position = hinge.position + frame * (turn * middle_of(options, side));
  pose.velocity += hinge.spin.cross(pose.position - hinge.position);
  return pose;
}

std::array<ToolHandle, 2> add_plates(Scene& scene, const std::string& name, const JawsOptions& options,
                                     const ToolPose& hinge) {
  require(options);
  if (name.empty()) throw Error("Jaws: expected a name, got an empty one");
  const auto plate = [&](std::size_t side) {
    const ToolPose pose = plate_at(options, hinge, side, options.opening);
    if (options.toughness) return Tool{.shape = Blade{options.length, *options.toughness}, .pose = pose};
    return Tool{.shape = Box{0.5 * Vec3(options.width, options.thickness, options.length)},
                .pose = pose,
                .friction = options.friction,
                .contact = options.contact};
  };
  const ToolHandle first = scene.add_tool(name + " 1", plate(0));
  try {
    return {first, scene.add_tool(name + " 2", plate(1))};
  } catch (...) {
    scene.remove_tool(name + " 1");
    throw;
  }
}

}  // namespace

Jaws::Jaws(Scene& scene, std::string_view name, const JawsOptions& options, const ToolPose& hinge)
    : options_(options), plates_(add_plates(scene, std::string(name), options, hinge)) {}

/// Of a plate's own axes at the end of the tick.
ToolPose Jaws::plate_pose(std::size_t side) const {
  ToolPose pose = plates_[side].target_pose();
  pose.orientation = Quaternion(Eigen::Quaterniond(pose.orientation) * axes_of(options_, side).conjugate());
  return pose;
}

double Jaws::angle() const {
  return plate_pose(0).orientation.angularDistance(plate_pose(1).orientation);
}

void Jaws::follow(const ToolPose& hinge, const ToolForce& on_first, const ToolForce& on_second, double dt) {
  require(dt >= 0.0, "a tick (s) of 0 or more", dt);
  // What the plates feel is of the tick before, and so is the hinge that it turned them about.
  const ToolPose at = plate_pose(0);
  const double before = angle();
  const Eigen::Quaterniond frame(Eigen::Quaterniond(at.orientation) * Eigen::AngleAxisd(-0.5 * before, Vec3::UnitX()));
  const Vec3 joint = at.position - Eigen::Quaterniond(at.orientation) * middle_of(options_, 0);
  force_ = torque_ = Vec3::Zero();
  double opens = 0.0;  // N m
  for (std::size_t side = 0; side < 2; ++side) {
    const ToolForce& on = side == 0 ? on_first : on_second;
    const Vec3 torque = on.mean_torque + (plates_[side].target_pose().position - joint).cross(on.mean_force);
    force_ += on.mean_force;
    torque_ += torque;
    opens += 0.5 * side_of[side] * torque.dot(frame * Vec3::UnitX());
  }
  grip_ = opens / options_.length;
  const double share = closes_ ? std::clamp(grip_ / options_.grip - 1.0, -1.0, 1.0) : 1.0;
  const double next = std::clamp(before + share * options_.speed * dt, 0.0, options_.opening);
  for (std::size_t side = 0; side < 2; ++side) plates_[side].move_to(plate_at(options_, hinge, side, next));
}

}  // namespace phymul
