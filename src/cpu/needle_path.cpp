// SPDX-License-Identifier: MIT
#include "needle_path.h"

#include <algorithm>
#include <cmath>

#include "../surface.h"
#include "needle_weights.h"

namespace phymul::cpu {
namespace {

/// Sweeps over the nodes of a step: after them, on a straight insertion, nodes lie within some 1e-3 of a step's motion
/// of where the limits let them be.
constexpr int sweeps = 12;

std::vector<std::array<Index, 3>> triangles_of(const Model& model) {
  const std::vector<char> all(model.rest.size(), 1);
  std::vector<std::array<Index, 3>> triangles;
  for (const Facet& facet : surface_facets(model, all)) {
    for (std::size_t k = 2; k < facet.particles.size(); ++k) {
      std::array<Index, 3> t{facet.particles[0], facet.particles[k - 1], facet.particles[k]};
      const Vec3 area = (model.rest[t[1]] - model.rest[t[0]]).cross(model.rest[t[2]] - model.rest[t[0]]);
      if (area.dot(facet.area) < 0.0) std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
  }
  return triangles;
}

/// Share of a triangle's side by which it is taken to be larger: a way along a line of the mesh must not pass between
/// two triangles by rounding.
constexpr double overlap = 1e-9;

/// Way along `direction` from `from` to the triangle; negative where there is none. (T. Moeller, B. Trumbore, J.
/// Graphics Tools 2 (1997) 21-28.) `facing`: > 0 where the triangle's outside looks along the direction.
double way_to(const std::array<Vec3, 3>& t, const Vec3& from, const Vec3& direction, double& facing) {
  const Vec3 e1 = t[1] - t[0], e2 = t[2] - t[0], p = direction.cross(e2);
  const double determinant = e1.dot(p);
  facing = -determinant;
  if (determinant == 0.0) return -1.0;
  const Vec3 s = from - t[0], q = s.cross(e1);
  const double u = s.dot(p) / determinant, v = direction.dot(q) / determinant;
  if (u < -overlap || v < -overlap || u + v > 1.0 + overlap) return -1.0;
  return e2.dot(q) / determinant;
}

std::array<Vec3, 3> corners(const std::array<Index, 3>& t, const FreeStep& step) {
  return {step.position(t[0]), step.position(t[1]), step.position(t[2])};
}

}  // namespace

NeedlePath::NeedlePath(const Needle& needle, double friction, const Model& model)
    : needle_(needle),
      friction_(friction),
      spread_(needle.spread > 0.0 ? needle.spread : 2.0 * mean_spacing(model)),
      facets_(triangles_of(model)) {
  found_.reserve(model.rest.size());
}

Vec3 NeedlePath::place(const NeedleNode& node, const FreeStep& step) {
  Vec3 x = Vec3::Zero();
  for (std::size_t k = 0; k < node.particles.size(); ++k) x += node.weights[k] * step.position(node.particles[k]);
  return x;
}

NeedleNode NeedlePath::node_at(const FreeStep& step, const Vec3& x) {
  NeedleNode node;
  double reach = spread_;
  do {
    found_.clear();
    step.find({.low = x - Vec3::Constant(reach), .high = x + Vec3::Constant(reach)}, found_);
    std::ranges::sort(found_);
    node = spread_weights(step, found_, x, reach);
    reach *= 1.5;
  } while (node.particles.empty() && found_.size() < found_.capacity());
  return node;
}

/// True where the shaft has come through the surface: the hole begins there.
bool NeedlePath::enter(const FreeStep& step, const Line& line) {
  double farthest = -1.0;  // from the tip
  for (const auto& t : facets_) {
    double facing = 0.0;
    const double way = way_to(corners(t, step), line.tip, line.axis, facing);
    if (way >= 0.0 && way <= needle_.length && facing > 0.0) farthest = std::max(farthest, way);
  }
  if (farthest < 0.0) return false;
  state_ = {};
  NeedleNode node = node_at(step, line.tip + farthest * line.axis);
  if (node.particles.empty()) return false;
  state_.hole.push_back(std::move(node));
  state_.slip = farthest;
  return true;
}

NeedlePath::Crossing NeedlePath::nearest_surface(const FreeStep& step, const Vec3& x, const Vec3& direction) const {
  Crossing nearest;
  for (const auto& t : facets_) {
    double facing = 0.0;
    const double way = way_to(corners(t, step), x, direction, facing);
    if (way >= 0.0 && (nearest.way < 0.0 || way < nearest.way)) nearest = {way, facing > 0.0};
  }
  return nearest;
}

/// New nodes on the way that the tip has made since the last one.
void NeedlePath::lengthen(const FreeStep& step, const Line& line) {
  for (double left = state_.slip - spread_; left > 0.0; left -= spread_) {
    state_.hole.push_back(node_at(step, line.tip + left * line.axis));
  }
  state_.slip = 0.0;
  // Out again where the nearest surface toward the hub is one it came out of. A mean over particles lies above the
  // deepest point of a dent, so that right after the puncture the tip may still be in front of the facets.
  const Crossing behind = nearest_surface(step, line.tip, line.axis);
  if (behind.way < 0.0 || behind.outward) {
    state_.hole.push_back(node_at(step, line.tip));
    return;
  }
  state_.through = true;
  state_.hole.push_back(node_at(step, line.tip + behind.way * line.axis));
}

void NeedlePath::follow(const TouchedParticles& touched, const Line& line) {
  const FreeStep& step = touched.step();
  if (state_.hole.empty() && !enter(step, line)) return;
  // Out again: as far as the skin gave way, so that rounding does not part them.
  if (line.along(place(state_.hole.front(), step)) < -0.1 * needle_.radius) {
    state_ = {};
    if (!enter(step, line)) return;
  }
  if (state_.through) return;
  state_.slip = std::max(state_.slip, line.along(place(state_.hole.back(), step)));
  if (!state_.punctured && state_.slip < needle_.radius) return;
  if (state_.punctured && state_.slip < spread_) return;
  state_.punctured = true;
  lengthen(step, line);
}

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
      if (touched[slot].fixed != 7)
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

void NeedlePath::rub(std::size_t k, TouchedParticles& touched, const Line&, const Line& end) {
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

void NeedlePath::act(TouchedParticles& touched, const ToolPose& start_pose, const ToolPose& end_pose,
                     ToolForce& force) {
  const Line start(start_pose), end(end_pose);
  follow(touched, start);
  given_.clear();
  if (state_.hole.empty()) return;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(end_pose.orientation * start_pose.orientation.conjugate()));
  // Orientations on the way between two equal ones differ by rounding, which is no turning.
  const double angle = turn.angle() * turn.axis().dot(end.axis);
  const double turned = std::abs(angle) > 1e-9 ? needle_.radius * angle : 0.0;
  couple(touched, start, turned);
  const std::size_t count = state_.hole.size();
  for (std::size_t k = 0; k < count && turned != 0.0; ++k) {
    if (!on_shaft(k) || coupled_[k].limit == 0.0) continue;
    const double slide = end.along(place_at_end(k, touched)) - coupled_[k].along;
    twist(k, touched, end, turned);
    coupled_[k].limit *= std::abs(slide) / std::hypot(slide, turned);
  }
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    if (!state_.through && coupled_[count - 1].inverse_mass > 0.0) push_ahead(touched, end);
    for (std::size_t k = 0; k < count; ++k) {
      if (coupled_[k].inverse_mass == 0.0) continue;
      const bool pressed = !state_.punctured || k + 1 == count;
      if (on_shaft(k) || (pressed && coupled_[k].pushed > 0.0)) hold_sideways(k, touched, end);
      if (on_shaft(k)) rub(k, touched, start, end);
    }
  }
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
}

}  // namespace phymul::cpu
