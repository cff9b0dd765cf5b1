// SPDX-License-Identifier: MIT
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/decimal.h"
#include "needle_path.h"
#include "scene/tool_state.h"
#include "tool_frame.h"

namespace phymul {

double tube_bending_stiffness(double outer_radius, double inner_radius, double young) {
  const bool sound = outer_radius > 0.0 && inner_radius >= 0.0 && inner_radius < outer_radius && young > 0.0 &&
                     std::isfinite(outer_radius) && std::isfinite(young);
  if (!sound) {
    throw Error(
        "tube_bending_stiffness: expected an outer radius above an inner one, which is 0 m or more, and a modulus " +
        std::string("above 0 Pa, all finite; got ") + to_decimal(outer_radius) + " m, " + to_decimal(inner_radius) +
        " m and " + to_decimal(young) + " Pa");
  }
  return young * std::numbers::pi / 4.0 * (std::pow(outer_radius, 4) - std::pow(inner_radius, 4));
}

ShaftLine::ShaftLine(const Needle& needle, const ToolPose& pose)
    : tip_(pose.position),
      axis_(pose.orientation * Vec3::UnitZ()),
      turn_(pose.orientation),
      arc_radius_(needle.arc_radius) {
  if (arc_radius_ == 0.0) return;
  round_ = 2.0 * std::numbers::pi * arc_radius_;
  ahead_ = 0.5 * (round_ - needle.length);
}

double ShaftLine::along(const Vec3& x) const {
  if (arc_radius_ == 0.0) return axis_.dot(x - tip_);
  const Vec3 q = turn_.conjugate() * (x - tip_);
  const double along = arc_radius_ * std::atan2(q.z(), arc_radius_ - q.x());
  return along < -ahead_ ? along + round_ : along;
}

Vec3 ShaftLine::place(double along) const {
  if (arc_radius_ == 0.0) return tip_ + along * axis_;
  const double half = std::sin(0.5 * along / arc_radius_);
  return tip_ + turn_ * Vec3(2.0 * arc_radius_ * half * half, 0.0, arc_radius_ * std::sin(along / arc_radius_));
}

Vec3 ShaftLine::axis(double along) const {
  if (arc_radius_ == 0.0) return axis_;
  return turn_ * Vec3(std::sin(along / arc_radius_), 0.0, std::cos(along / arc_radius_));
}

Vec3 ShaftLine::aside(const Vec3& x) const {
  if (arc_radius_ == 0.0) return x - tip_ - along(x) * axis_;
  return x - place(along(x));
}

Vec3 shaft_place(const Needle& needle, double along) {
  return ShaftLine(needle, {}).place(along);
}

double shaft_compliance(const Needle& needle, double at, double from) {
  if (needle.bending_stiffness == 0.0) return 0.0;
  const double a = std::clamp(needle.length - at, 0.0, needle.length);
  const double b = std::clamp(needle.length - from, 0.0, needle.length);
  const double nearer = std::min(a, b), farther = std::max(a, b);
  return nearer * nearer * (3.0 * farther - nearer) / (6.0 * needle.bending_stiffness);
}

bool is_ahead_of_tip(const Needle& needle, double along) {
  return along < -0.1 * needle.radius;
}

Vec3 shaft_deflection(const Needle& needle, std::span<const ShaftLoad> loads, double along) {
  Vec3 u = Vec3::Zero();
  for (const ShaftLoad& load : loads) u += shaft_compliance(needle, along, load.along) * Vec3(load.x, load.y, 0.0);
  return u;
}

VecList shaft_points(const Needle& needle, std::span<const ShaftLoad> loads, int count) {
  if (count < 2) throw Error("shaft_points: expected 2 places or more, got " + std::to_string(count));
  VecList points;
  for (int k = 0; k < count; ++k) {
    const double along = needle.length * k / (count - 1);
    points.push_back(shaft_place(needle, along) + shaft_deflection(needle, loads, along));
  }
  return points;
}

namespace {

/// Sweeps over the nodes of a step: after them, on a straight insertion, nodes lie within some 1e-3 of a step's motion
/// of where the limits let them be.
constexpr int sweeps = 12, free_sweeps = 48;

}  // namespace

Vec3 NeedlePath::place_at_end(std::size_t k, TouchedParticles& touched) const {
  Vec3 x = Vec3::Zero();
  for (std::size_t j = 0; j < coupled_[k].slots.size(); ++j) {
    x += state_.hole[k].weights[j] * touched[coupled_[k].slots[j]].end(touched.dt());
  }
  return x;
}

void NeedlePath::give(std::size_t k, const Vec3& impulse, double dt) {
  for (const Reached& reached : coupled_[k].reached) {
    coupled_[reached.node].end += dt * reached.along_axes.cwiseProduct(impulse);
  }
}

/// What nodes have been given, to the particles that they are means of.
void NeedlePath::hand_over(TouchedParticles& touched) {
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    const Coupled& node = coupled_[k];
    const Vec3 impulse = node.sideways + (node.rubbed - node.pushed) * node.axis;
    if (impulse == Vec3::Zero()) continue;
    for (std::size_t j = 0; j < node.slots.size(); ++j) {
      TouchedParticles::Touched& particle = touched[node.slots[j]];
      if (particle.held) continue;
      const Vec3 share = state_.hole[k].weights[j] * impulse;
      TouchedParticles::push(particle, share);
      given_.emplace_back(node.slots[j], share);
    }
  }
}

/// The tip on the surface holds it by dry friction only.
Vec3 NeedlePath::limited(std::size_t k, const Vec3& sideways) const {
  const double most = friction_ * coupled_[k].pushed, size = sideways.norm();
  const bool presses = !state_.punctured && k + 1 == state_.hole.size();
  return presses && size > most ? Vec3(sideways * (most / size)) : sideways;
}

/// Onto the axis.
void NeedlePath::hold_sideways(std::size_t k, const ShaftLine& end, double dt) {
  Coupled& node = coupled_[k];
  const Vec3 wanted = limited(k, node.sideways - end.aside(node.end) / (dt * node.inverse_mass));
  give(k, wanted - node.sideways, dt);
  node.sideways = wanted;
}

/// Onto the bent shaft, all nodes at once: where the step ends, the shaft is bent by what it holds the tissue with.
void NeedlePath::hold_on_bent(const ShaftLine& end, double dt) {
  const auto count = static_cast<Eigen::Index>(held_.size());
  if (count == 0) return;
  for (Eigen::Index row = 0; row < count; ++row) {
    Vec3 off = end.aside(coupled_[held_[row]].end);
    for (Eigen::Index k = 0; k < count; ++k) {
      off += compliance_(row, k) / dt * coupled_[held_[k]].sideways;
    }
    off_.row(row) = off.transpose();
  }
  const auto factor = gives_.topLeftCorner(count, count).triangularView<Eigen::Lower>();
  auto off = off_.topRows(count);
  factor.solveInPlace(off);
  factor.adjoint().solveInPlace(off);
  for (Eigen::Index row = 0; row < count; ++row) {
    Coupled& node = coupled_[held_[row]];
    const Vec3 wanted = limited(held_[row], node.sideways - off.row(row).transpose());
    give(held_[row], wanted - node.sideways, dt);
    node.sideways = wanted;
  }
}

void NeedlePath::rub(std::size_t k, const ShaftLine& end, double dt) {
  Coupled& node = coupled_[k];
  const double slide = end.along(node.end) - node.along;
  const double wanted = std::clamp(node.rubbed - slide / (dt * node.inverse_mass), -node.limit, node.limit);
  give(k, (wanted - node.rubbed) * node.axis, dt);
  node.rubbed = wanted;
}

/// The last node stays ahead of the tip, but for what has slipped past, as long as that takes less than the limit.
void NeedlePath::push_ahead(const ShaftLine& end, double dt) {
  const std::size_t k = state_.hole.size() - 1;
  Coupled& node = coupled_[k];
  const double behind = end.along(node.end) - state_.slip;
  const double wanted = std::clamp(node.pushed + behind / (dt * node.inverse_mass), 0.0, most_push_ * dt);
  give(k, (node.pushed - wanted) * node.axis, dt);
  node.pushed = wanted;
}

/// The part of friction around a shaft that turns by `turned` m at its surface: a torque on the particles around the
/// node.
void NeedlePath::twist(std::size_t k, TouchedParticles& touched, const ShaftLine& end, double turned) {
  const Coupled& node = coupled_[k];
  const double slide = end.along(place_at_end(k, touched)) - node.along, all = std::hypot(slide, turned);
  const double torque = node.limit * needle_.radius * turned / all;
  double inertia = 0.0;
  for (std::size_t j = 0; j < node.slots.size(); ++j) {
    inertia += state_.hole[k].weights[j] * end.aside(touched[node.slots[j]].position).squaredNorm();
  }
  if (!(inertia > 0.1 * needle_.radius * needle_.radius)) return;
  for (std::size_t j = 0; j < node.slots.size(); ++j) {
    TouchedParticles::Touched& particle = touched[node.slots[j]];
    const Vec3 around = node.axis.cross(end.aside(particle.position));
    if (particle.held) continue;
    given_.emplace_back(node.slots[j],
                        TouchedParticles::push(particle, torque / inertia * state_.hole[k].weights[j] * around));
  }
}

/// Impulses within their limits.
void NeedlePath::settle(TouchedParticles& touched, ToolPose& end_pose) {
  ShaftLine end(needle_, end_pose);
  const std::size_t count = state_.hole.size();
  const bool bends = needle_.bending_stiffness > 0.0;
  const double dt = touched.dt();
  for (std::size_t k = 0; k < count; ++k) coupled_[k].end = place_at_end(k, touched);
  if (bends) couple_sideways(dt);
  for (int sweep = 0; sweep < (state_.free ? free_sweeps : sweeps); ++sweep) {
    if (state_.free && sweep > 0) {
      end_pose = balanced(end_pose, dt);
      end = ShaftLine(needle_, end_pose);
    }
    if (!state_.through && coupled_[count - 1].inverse_mass > 0.0) push_ahead(end, dt);
    if (bends) hold_on_bent(end, dt);
    for (std::size_t k = 0; k < count; ++k) {
      if (coupled_[k].inverse_mass == 0.0) continue;
      // In the tissue the tip holds its node whether it pushes or not: where nothing moves that is a rounding error.
      const bool at_tip = k + 1 == count && !state_.through &&
                          (state_.punctured ? !is_ahead_of_tip(needle_, coupled_[k].along) : coupled_[k].pushed > 0.0);
      if (!bends && (on_shaft(k) || at_tip)) hold_sideways(k, end, dt);
      if (on_shaft(k)) rub(k, end, dt);
    }
  }
  hand_over(touched);
  if (!bends) return;
  for (const std::size_t k : held_) {
    const Vec3 load = -(end.turn().conjugate() * coupled_[k].sideways) / dt;
    loads_.push_back({.along = coupled_[k].along, .x = load.x(), .y = load.y()});
  }
}

void NeedlePath::act(TouchedParticles& touched, const ToolPose& start_pose, bool placed, ToolPose& end_pose,
                     ToolForce& force) {
  const ShaftLine start(needle_, start_pose);
  gives_way_ = false;
  follow(touched, start, placed);
  given_.clear();
  loads_.clear();
  if (state_.free) end_pose = {.position = start_pose.position, .orientation = start_pose.orientation};
  if (state_.hole.empty()) return;
  couple(touched, start);
  if (state_.free) end_pose = carried(touched, start_pose);
  const ShaftLine end(needle_, end_pose);
  // An arc has no axis to turn about, and a free needle turns with the tissue.
  const double turned =
      needle_.arc_radius > 0.0 || state_.free ? 0.0 : needle_.radius * needle_turn(start_pose, end_pose);
  for (std::size_t k = 0; k < state_.hole.size(); ++k) coupled_[k].axis = end.axis(coupled_[k].along);
  limit(turned, touched.dt());
  const std::size_t count = state_.hole.size();
  for (std::size_t k = 0; k < count && turned != 0.0; ++k) {
    if (!on_shaft(k) || coupled_[k].limit == 0.0) continue;
    const double slide = end.along(place_at_end(k, touched)) - coupled_[k].along;
    twist(k, touched, end, turned);
    coupled_[k].limit *= std::abs(slide) / std::hypot(slide, turned);
  }
  settle(touched, end_pose);
  for (std::size_t k = 0; k < count; ++k) {
    coupled_[k].slides = coupled_[k].limit > 0.0 && std::abs(coupled_[k].rubbed) >= coupled_[k].limit;
  }
  const ToolFrame frame(end_pose);
  const int before = force.particles;
  for (const auto& [slot, impulse] : given_) react(force, frame, touched[slot].position, impulse, touched.dt());
  force.particles = before;
  for (std::size_t k = 0; k < count; ++k) {
    if (on_shaft(k) || coupled_[k].pushed > 0.0) force.particles += static_cast<int>(coupled_[k].slots.size());
  }
}

void NeedlePath::accept() {
  for (std::size_t k = 0; k < state_.hole.size(); ++k) state_.hole[k].slides = coupled_[k].slides;
  state_.shaft = loads_;
  gave_way_ += gives_way_ ? 1 : 0;
}

}  // namespace phymul
