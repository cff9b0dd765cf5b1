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
}

/// The plate of the side that lies on the plane y = 0, turned about the hinge by half of the angle.
ToolPose plate_at(const JawsOptions& options, const ToolPose& hinge, std::size_t side, double angle) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * side_of[side] * angle, Vec3::UnitX()));
  const Vec3 middle(0.0, 0.5 * side_of[side] * options.thickness, -0.5 * options.length);
  const Eigen::Quaterniond frame(hinge.orientation.normalized());
  ToolPose pose = hinge;
  pose.orientation = Quaternion(frame * turn);
  pose.position = hinge.position + frame * (turn * middle);
  pose.velocity += hinge.spin.cross(pose.position - hinge.position);
  return pose;
}

std::array<ToolHandle, 2> add_plates(Scene& scene, const std::string& name, const JawsOptions& options,
                                     const ToolPose& hinge) {
  require(options);
  const auto plate = [&](std::size_t side) {
    return Tool{.shape = Box{0.5 * Vec3(options.width, options.thickness, options.length)},
                .pose = plate_at(options, hinge, side, options.opening),
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

double Jaws::angle() const {
  return plates_[0].target_pose().orientation.angularDistance(plates_[1].target_pose().orientation);
}

void Jaws::follow(const ToolPose& hinge, const ToolForce& on_first, const ToolForce& on_second, double dt) {
  require(dt >= 0.0, "a tick (s) of 0 or more", dt);
  // What the plates feel is of the tick before, and so is the hinge that it turned them about.
  const ToolPose& at = plates_[0].target_pose();
  const double before = angle();
  const Eigen::Quaterniond frame(Eigen::Quaterniond(at.orientation) * Eigen::AngleAxisd(-0.5 * before, Vec3::UnitX()));
  const Vec3 middle(0.0, 0.5 * options_.thickness, -0.5 * options_.length);
  const Vec3 joint = at.position - Eigen::Quaterniond(at.orientation) * middle;
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
