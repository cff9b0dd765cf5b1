// SPDX-License-Identifier: MIT
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "../needle_measures.h"
#include "../needle_shaft.h"
#include "needle_path.h"

namespace phymul::cpu {
namespace {

/// Sweeps over the nodes of a step: after them, on a straight insertion, nodes lie within some 1e-3 of a step's motion
/// of where the limits let them be.
constexpr int sweeps = 12;

/// By how much a held node counts as softer than it is: two nodes that move as one leave no system singular.
constexpr double slack = 1e-9;

}  // namespace

/// All nodes but the one ahead of the tip.
bool NeedlePath::on_shaft(std::size_t node) const {
  const bool end = node + 1 == state_.hole.size() && !state_.through;
  return state_.punctured && !end && coupled_[node].along > 0.0;
}

/// Each node on the shaft rubs over half of the way to the next ones; the first up to the surface, the last to the tip
/// or to where the shaft comes out.
void NeedlePath::share_out_length() {
  double above = -1.0;  // along, of the border to the node before
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    Coupled& node = coupled_[k];
    node.length = 0.0;
    if (!on_shaft(k)) continue;
    if (above < 0.0) above = node.along;
    const bool last = k + 1 == state_.hole.size() || !on_shaft(k + 1);
    const double end = state_.through && k + 1 == state_.hole.size() ? node.along : 0.0;
    const double below = last ? end : 0.5 * (node.along + coupled_[k + 1].along);
    node.length = std::max(0.0, above - below);
    above = below;
  }
}

/// Friction acts against the whole sliding, of which a turning shaft has a part around it: what is left lengthwise is
/// that much smaller.
void NeedlePath::couple(TouchedParticles& touched, const Line& start, double turned) {
  const std::size_t count = state_.hole.size();
  if (coupled_.size() < count) coupled_.resize(2 * count);
  for (std::size_t k = 0; k < count; ++k) {
    const NeedleNode& node = state_.hole[k];
    Coupled& coupled = coupled_[k];
    coupled.slots.clear();
    coupled.inverse_mass = coupled.rubbed = coupled.pushed = 0.0;
    coupled.sideways.setZero();
    coupled.slides = node.slides;
    for (std::size_t j = 0; j < node.particles.size(); ++j) {
      const std::size_t slot = touched.slot(node.particles[j]);
      coupled.slots.push_back(slot);
      if (touched[slot].fixed != 7 && !touched[slot].held)
        coupled.inverse_mass += node.weights[j] * node.weights[j] * touched[slot].inverse_mass;
    }
    coupled.along = start.along(place(node, touched.step()));
  }
  share_out_length();
  for (std::size_t k = 0; k < count; ++k) {
    Coupled& node = coupled_[k];
    const bool slides = node.slides || turned != 0.0;
    node.limit = (slides ? needle_.kinetic_friction : needle_.static_friction) * node.length * touched.dt();
  }
}

Vec3 NeedlePath::place_at_end(std::size_t k, TouchedParticles& touched) const {
  Vec3 x = Vec3::Zero();
  for (std::size_t j = 0; j < coupled_[k].slots.size(); ++j) {
    x += state_.hole[k].weights[j] * touched[coupled_[k].slots[j]].end(touched.dt());
  }
  return x;
}

void NeedlePath::give(std::size_t k, TouchedParticles& touched, const Vec3& impulse) {
  for (std::size_t j = 0; j < coupled_[k].slots.size(); ++j) {
    TouchedParticles::Touched& particle = touched[coupled_[k].slots[j]];
    if (particle.held) continue;
    const Vec3 share = state_.hole[k].weights[j] * impulse;
    TouchedParticles::push(particle, share);
    given_.emplace_back(coupled_[k].slots[j], share);
  }
}

/// Onto the axis. The tip on the surface holds it by dry friction only.
void NeedlePath::hold_sideways(std::size_t k, TouchedParticles& touched, const Line& end) {
  Coupled& node = coupled_[k];
  Vec3 wanted = node.sideways - end.aside(place_at_end(k, touched)) / (touched.dt() * node.inverse_mass);
  const double most = friction_ * node.pushed, size = wanted.norm();
  if (!state_.punctured && size > most) wanted *= most / size;
  give(k, touched, wanted - node.sideways);
  node.sideways = wanted;
}

/// Which nodes a shaft that bends holds, and how each moves under an impulse on each: by the tissue's inertia and by
/// the shaft giving way. Held are those on the shaft and the one at the tip, but no two closer than half a spread:
/// closer ones move as one, and forces against each other would only turn the tissue.
void NeedlePath::couple_sideways(TouchedParticles& touched) {
  held_.clear();
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    const Coupled& node = coupled_[k];
    const bool at_tip =
        k + 1 == state_.hole.size() && !state_.through && (!state_.punctured || !is_ahead_of_tip(needle_, node.along));
    if (!on_shaft(k) && !at_tip) continue;
    if (node.inverse_mass == 0.0 && shaft_compliance(needle_, node.along, node.along) == 0.0) continue;
    if (!held_.empty() && coupled_[held_.back()].along - node.along < 0.5 * spread_) continue;
    held_.push_back(k);
  }
  const auto count = static_cast<Eigen::Index>(held_.size());
  const double dt = touched.dt();
  if (gives_.rows() < count) {  // more than it takes now: it changes from step to step
    gives_.resize(2 * count, 2 * count);
    compliance_.resize(2 * count, 2 * count);
    off_.resize(2 * count, 3);
  }
  share_of_.assign(touched.count(), 0.0);
  for (Eigen::Index row = 0; row < count; ++row) {
    const Coupled& node = coupled_[held_[row]];
    const auto each_share = [&](const auto& visit) {
      for (std::size_t j = 0; j < node.slots.size(); ++j) visit(node.slots[j], state_.hole[held_[row]].weights[j]);
    };
    each_share([&](std::size_t slot, double weight) {
      const TouchedParticles::Touched& particle = touched[slot];
      if (particle.fixed != 7 && !particle.held) share_of_[slot] = weight * particle.inverse_mass;
    });
    for (Eigen::Index column = 0; column < count; ++column) {
      const Coupled& other = coupled_[held_[column]];
      double inverse_mass = 0.0;
      for (std::size_t j = 0; j < other.slots.size(); ++j) {
        inverse_mass += state_.hole[held_[column]].weights[j] * share_of_[other.slots[j]];
      }
      compliance_(row, column) = shaft_compliance(needle_, node.along, other.along);
      gives_(row, column) = dt * inverse_mass + compliance_(row, column) / dt;
    }
    each_share([&](std::size_t slot, double) { share_of_[slot] = 0.0; });
  }
  auto gives = gives_.topLeftCorner(count, count);
  gives.diagonal() *= 1.0 + slack;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(gives);
  if (in_place.info() != Eigen::Success) held_.clear();
}

/// Onto the bent shaft, all nodes at once: where the step ends, the shaft is bent by what it holds the tissue with.
void NeedlePath::hold_on_bent(TouchedParticles& touched, const Line& end) {
  const auto count = static_cast<Eigen::Index>(held_.size());
  if (count == 0) return;
  for (Eigen::Index row = 0; row < count; ++row) {
    Vec3 off = end.aside(place_at_end(held_[row], touched));
    for (Eigen::Index k = 0; k < count; ++k) {
      off += compliance_(row, k) / touched.dt() * coupled_[held_[k]].sideways;
    }
    off_.row(row) = off.transpose();
  }
  const auto factor = gives_.topLeftCorner(count, count).triangularView<Eigen::Lower>();
  auto off = off_.topRows(count);
  factor.solveInPlace(off);
  factor.adjoint().solveInPlace(off);
  for (Eigen::Index row = 0; row < count; ++row) {
    Coupled& node = coupled_[held_[row]];
    Vec3 wanted = node.sideways - off.row(row).transpose();
    const double most = friction_ * node.pushed, size = wanted.norm();
    if (!state_.punctured && size > most) wanted *= most / size;
    give(held_[row], touched, wanted - node.sideways);
    node.sideways = wanted;
  }
}

void NeedlePath::rub(std::size_t k, TouchedParticles& touched, const Line& end) {
  Coupled& node = coupled_[k];
  const double slide = end.along(place_at_end(k, touched)) - node.along;
  const double wanted = std::clamp(node.rubbed - slide / (touched.dt() * node.inverse_mass), -node.limit, node.limit);
  give(k, touched, (wanted - node.rubbed) * end.axis);
  node.rubbed = wanted;
}

/// The last node stays ahead of the tip, but for what has slipped past, as long as that takes less than the limit.
void NeedlePath::push_ahead(TouchedParticles& touched, const Line& end) {
  const std::size_t k = state_.hole.size() - 1;
  Coupled& node = coupled_[k];
  const double behind = end.along(place_at_end(k, touched)) - state_.slip;
  const double most = (state_.punctured ? needle_.cutting : needle_.puncture) * touched.dt();
  const double wanted = std::clamp(node.pushed + behind / (touched.dt() * node.inverse_mass), 0.0, most);
  give(k, touched, (node.pushed - wanted) * end.axis);
  node.pushed = wanted;
}

/// The part of friction around a shaft that turns by `turned` m at its surface: a torque on the particles around the
/// node.
void NeedlePath::twist(std::size_t k, TouchedParticles& touched, const Line& end, double turned) {
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
    const Vec3 around = end.axis.cross(end.aside(particle.position));
    if (particle.held) continue;
    given_.emplace_back(node.slots[j],
                        TouchedParticles::push(particle, torque / inertia * state_.hole[k].weights[j] * around));
  }
}

/// Impulses within their limits.
void NeedlePath::settle(TouchedParticles& touched, const Line& end) {
  const std::size_t count = state_.hole.size();
  const bool bends = needle_.bending_stiffness > 0.0;
  if (bends) couple_sideways(touched);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    if (!state_.through && coupled_[count - 1].inverse_mass > 0.0) push_ahead(touched, end);
    if (bends) hold_on_bent(touched, end);
    for (std::size_t k = 0; k < count; ++k) {
      if (coupled_[k].inverse_mass == 0.0) continue;
      const bool pressed = !state_.punctured || k + 1 == count;
      if (!bends && (on_shaft(k) || (pressed && coupled_[k].pushed > 0.0))) hold_sideways(k, touched, end);
      if (on_shaft(k)) rub(k, touched, end);
    }
  }
  if (!bends) return;
  for (const std::size_t k : held_) {
    const Vec3 load = -(end.turn.conjugate() * coupled_[k].sideways) / touched.dt();
    loads_.push_back({.along = coupled_[k].along, .x = load.x(), .y = load.y()});
  }
}

void NeedlePath::act(TouchedParticles& touched, const ToolPose& start_pose, const ToolPose& end_pose,
                     ToolForce& force) {
  const Line start(start_pose), end(end_pose);
  follow(touched, start);
  given_.clear();
  loads_.clear();
  if (state_.hole.empty()) return;
  const double turned = needle_.radius * needle_turn(start_pose, end_pose);
  couple(touched, start, turned);
  const std::size_t count = state_.hole.size();
  for (std::size_t k = 0; k < count && turned != 0.0; ++k) {
    if (!on_shaft(k) || coupled_[k].limit == 0.0) continue;
    const double slide = end.along(place_at_end(k, touched)) - coupled_[k].along;
    twist(k, touched, end, turned);
    coupled_[k].limit *= std::abs(slide) / std::hypot(slide, turned);
  }
  settle(touched, end);
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
}

}  // namespace phymul::cpu
