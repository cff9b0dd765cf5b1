// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/jaws.h>
#include <phymul/virtual_coupling.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "tool_frame.h"

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
  const Eigen::AngleAxisd angle(Eigen::Quaterniond(to * from.conjugate()));  // of 0 to pi, whatever the sign
  return angle.angle() * angle.axis();
}

bool is_pose(const ToolPose& pose) {
  return is_finite(pose) && pose.orientation.norm() > 0.0;
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
  if (!is_pose(device)) {
    throw Error("VirtualCoupling: expected a pose of finite numbers and an orientation that is not zero");
  }
  tool_ = device;
  tool_.orientation.normalize();
  force_ = torque_ = Vec3::Zero();
  moved_ = {.velocity = tool_.velocity, .spin = tool_.spin};
}

void VirtualCoupling::Moved::to(const Vec3& next_velocity, const Vec3& next_spin, double over) {
  if (over > 0.0) {
    acceleration = (next_velocity - velocity) / over;
    spin_up = (next_spin - spin) / over;
    dt = over;
  }
  velocity = next_velocity;
  spin = next_spin;
}

/// The tool's velocities at the tick's end where it holds what `load` says.
///
/// What it holds it moves rigidly, so that of the force F reported of the tick before, -G A is what this cost: A the
/// tool's accelerations in that tick, G the held mass as a matrix over velocity and spin,
///
///   G = [ M 1     -M [c]x ]     M: its mass, c: its centre from the tool's position,
///       [ M [c]x      J   ]     J: its inertia about that position.
///
/// Left in F, it comes a tick late: of the tool by itself, m A+ = -G A, which grows by M / m a tick, with a change of
/// sign, whatever the tick: a shorter one makes it fail sooner, and the tissue's damping has no part in it. It is the
/// added mass of partitioned schemes (P. Causin, J.-F. Gerbeau, F. Nobile, "Added-mass effect in the design of
/// partitioned algorithms for fluid-structure problems", Comput. Methods Appl. Mech. Eng. 194 (2005) 4506-4527).
/// Therefore it is taken out of F, which leaves what the held tissue weighs and what the rest of the body pulls, and
/// stands on the left-hand side, at the tick's end:
///
///   (diag(mass, inertia) + G) V+ = diag(m, i) V + G U + dt (P + F + G A)
///
/// with mass = m + dt b + dt^2 k and P the part of spring and damper that is known, as in follow(). U is how the tool
/// was moved in the tick before; V, its own velocity, is another one only after a tick that was left out.
VirtualCoupling::Velocities VirtualCoupling::carrying(const ToolForce& load, const Vec3& pull, const Vec3& twist,
                                                      double mass, double inertia, double dt) const {
  const Mat3 turn = tool_.orientation.toRotationMatrix();
  const Vec3 moment = load.held_mass * (turn * load.held_centre);  // M c, of the corners of G
  const Mat3 held = turn * load.held_inertia * turn.transpose();
  const Vec3 before = moved_.velocity + dt * moved_.acceleration;
  const Vec3 turned_before = moved_.spin + dt * moved_.spin_up;
  const Vec3 momentum =
      options_.mass * tool_.velocity + dt * pull + load.held_mass * before - moment.cross(turned_before);
  const Vec3 spin_momentum = options_.inertia * tool_.spin + dt * twist + moment.cross(before) + held * turned_before;
  // The velocity's block is a number times the identity, so that it is eliminated: what is left is of the spin alone,
  // and positive definite, because J is at least the inertia of M at c. [M c]x [M c]x = M c (M c)^T - |M c|^2.
  const double whole = mass + load.held_mass;
  Mat3 left = held + moment * moment.transpose() / whole;
  left.diagonal().array() += inertia - moment.squaredNorm() / whole;
  const Vec3 spin = left.llt().solve(spin_momentum - moment.cross(momentum) / whole);
  return {(momentum + moment.cross(spin)) / whole, spin};
}

/// The host moves the tool to where it is, or leaves it there: what it holds stands still in this tick.
const ToolPose& VirtualCoupling::leave_out(double dt) {
  moved_.to(Vec3::Zero(), Vec3::Zero(), dt > 0.0 && std::isfinite(dt) ? dt : moved_.dt);
  return tool_;
}

const ToolPose& VirtualCoupling::follow(const ToolPose& device, const Vec3& force_on_tool, const Vec3& torque_on_tool,
                                        double dt) {
  return follow(device, ToolForce{.mean_force = force_on_tool, .mean_torque = torque_on_tool}, dt);
}

const ToolPose& VirtualCoupling::follow(const ToolPose& device, const ToolForce& on_tool, double dt) {
  if (!(dt >= 0.0)) return leave_out(dt);
  // m (v+ - v) / dt = k (x_device - x - dt v+) + b (v_device - v+) + F, solved for v+; the same for turning.
  const CouplingOptions& o = options_;
  ToolPose next = tool_;
  const Vec3 pull = o.stiffness * (device.position - tool_.position) + o.damping * device.velocity + on_tool.mean_force;
  const Vec3 twist = o.turning_stiffness * turn_between(tool_.orientation, device.orientation) +
                     o.turning_damping * device.spin + on_tool.mean_torque;
  const double mass = o.mass + dt * o.damping + dt * dt * o.stiffness;
  const double inertia = o.inertia + dt * o.turning_damping + dt * dt * o.turning_stiffness;
  if (on_tool.held_mass != 0.0) {
    const Velocities both = carrying(on_tool, pull, twist, mass, inertia, dt);
    next.velocity = both.velocity;
    next.spin = both.spin;
  } else {
    next.velocity = (o.mass * tool_.velocity + dt * pull) / mass;
    next.spin = (o.inertia * tool_.spin + dt * twist) / inertia;
  }
  next.position += dt * next.velocity;
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
  if (!is_pose(next) || !is_pose(device) || !std::isfinite(sizes)) return leave_out(dt);
  moved_.to(next.velocity, next.spin, dt);
  tool_ = next;
  force_ = limited(force, o.largest_force);
  torque_ = limited(torque, o.largest_torque);
  return tool_;
}

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
