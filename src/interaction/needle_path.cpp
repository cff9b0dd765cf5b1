// SPDX-License-Identifier: MIT
#include "needle_path.h"

#include <algorithm>

#include "model/surface_facets.h"
#include "needle_shaft.h"
#include "needle_weights.h"
#include "scene/needle_measures.h"

namespace phymul {
namespace {

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

std::array<Vec3, 3> corners(const std::array<Index, 3>& t, const PredictedStep& step) {
  return {step.position(t[0]), step.position(t[1]), step.position(t[2])};
}

}  // namespace

NeedlePath::NeedlePath(const Needle& needle, double friction, const Model& model)
    : needle_(needle),
      friction_(friction),
      spread_(needle_spread(needle, model)),
      support_radius_(needle_support_radius(spread_, model)) {
  found_.reserve(model.rest.size());
  sides_.resize(model.rest.size());
  follow_body(model);
}

void NeedlePath::follow_body(const Model& model) {
  facets_ = outward_triangles(model);
  surface_.clear();
  for (const auto& t : facets_) surface_.insert(surface_.end(), t.begin(), t.end());
  std::ranges::sort(surface_);
  surface_.erase(std::ranges::unique(surface_).begin(), surface_.end());
  removed_.assign(model.mass.size(), 0);
  for (std::size_t i = 0; i < removed_.size(); ++i) removed_[i] = model.mass[i] == 0.0 ? 1 : 0;
  std::erase_if(state_.hole, [&](const NeedleNode& node) {
    return std::ranges::any_of(node.particles, [&](Index i) { return removed_[i] != 0; });
  });
  needle_bearing(model, factors_, bearing_);
}

void NeedlePath::follow_stiffness(const Model& model, std::span<const double> factors) {
  if (std::ranges::equal(factors, factors_)) return;
  factors_.assign(factors.begin(), factors.end());
  needle_bearing(model, factors_, bearing_);
}

Vec3 NeedlePath::place(const NeedleNode& node, const PredictedStep& step) {
  Vec3 x = Vec3::Zero();
  for (std::size_t k = 0; k < node.particles.size(); ++k) x += node.weights[k] * step.position(node.particles[k]);
  return x;
}

NeedleNode NeedlePath::node_at(const PredictedStep& step, const Vec3& x) {
  NeedleNode node;
  if (!x.allFinite()) return node;
  double support_radius = support_radius_;
  do {
    found_.clear();
    step.find({.low = x - Vec3::Constant(support_radius), .high = x + Vec3::Constant(support_radius)}, found_);
    std::erase_if(found_, [&](Index i) { return removed_[i] != 0; });
    std::ranges::sort(found_);
    node = spread_weights(step, found_, x, support_radius);
    support_radius *= 1.5;
  } while (node.particles.empty() && found_.size() < found_.capacity());
  return node;
}

/// On which sides of the box around the shaft each particle of the surface is: what is on one side with all its corners
/// does not meet the shaft (D. Cohen and I. Sutherland's outcodes). Most of a surface is away from it.
void NeedlePath::look_around_shaft(const PredictedStep& step, const Line& line) {
  const Vec3 hub = line.tip + needle_.length * line.axis;
  const double more = 1e-6 * needle_.length;  // than rounding and `overlap`
  const Vec3 low = line.tip.cwiseMin(hub).array() - more, high = line.tip.cwiseMax(hub).array() + more;
  for (const Index i : surface_) {
    const Vec3 x = step.position(i);
    unsigned sides = 0;
    for (int a = 0; a < 3; ++a) sides |= (x[a] < low[a] ? 1u : 0u) << a | (x[a] > high[a] ? 8u : 0u) << a;
    sides_[i] = static_cast<std::uint8_t>(sides);
  }
}

/// True where the shaft has come through the surface: the hole begins there.
bool NeedlePath::enter(const PredictedStep& step, const Line& line) {
  look_around_shaft(step, line);
  double farthest = -1.0;  // from the tip
  for (const auto& t : facets_) {
    if ((sides_[t[0]] & sides_[t[1]] & sides_[t[2]]) != 0) continue;
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

NeedlePath::Crossing NeedlePath::nearest_surface(const PredictedStep& step, const Vec3& x,
                                                 const Vec3& direction) const {
  Crossing nearest;
  for (const auto& t : facets_) {
    double facing = 0.0;
    const double way = way_to(corners(t, step), x, direction, facing);
    if (way >= 0.0 && (nearest.way < 0.0 || way < nearest.way)) nearest = {way, facing > 0.0};
  }
  return nearest;
}

Vec3 NeedlePath::shaft_at(const Line& line, double along) const {
  Vec3 straight = line.tip + along * line.axis;
  if (state_.shaft.empty()) return straight;
  return straight + line.turn * shaft_deflection(needle_, state_.shaft, along);
}

/// N, at which the tissue around a node has reached its limit of stretch.
double NeedlePath::bears(const NeedleNode& node) const {
  double sum = 0.0, weight = 0.0;
  for (std::size_t k = 0; k < node.particles.size(); ++k) {
    if (!(node.weights[k] > 0.0)) continue;
    sum += node.weights[k] * bearing_[node.particles[k]];
    weight += node.weights[k];
  }
  return sum / weight * spread_ * spread_;
}

/// New nodes on the way that the tip has made since the last one.
void NeedlePath::lengthen(const PredictedStep& step, const Line& line) {
  const bool first = state_.hole.size() == 1;
  const auto add = [&](const Vec3& x) {
    NeedleNode node = node_at(step, x);
    if (!node.particles.empty()) state_.hole.push_back(std::move(node));
  };
  // A state from a file may have a longer way than a shaft.
  for (double left = std::min(state_.slip, needle_.length) - spread_; left > 0.0; left -= spread_) {
    add(shaft_at(line, left));
  }
  state_.slip = 0.0;
  // Out again where the nearest surface back along the shaft is one it came out of. A mean over particles lies above
  // the deepest point of a dent, so that right after the puncture the tip may still be in front of the facets.
  const Vec3 tip = shaft_at(line, 0.0);
  const Vec3 back = (shaft_at(line, std::min(spread_, needle_.length)) - tip).normalized();
  const Crossing behind = nearest_surface(step, tip, back);
  const auto body_is_ahead = [&] {
    const Crossing ahead = nearest_surface(step, tip, -back);
    return ahead.way >= 0.0 && ahead.outward;
  };
  const bool in = behind.way >= 0.0 ? behind.outward : first || body_is_ahead();
  if (in) return add(tip);
  state_.through = true;
  if (behind.way >= 0.0) add(tip + behind.way * back);
}

void NeedlePath::follow(const TouchedParticles& touched, const Line& line) {
  const PredictedStep& step = touched.step();
  const bool pressed = !state_.hole.empty();
  if (state_.hole.empty() && !enter(step, line)) return;
  // Out again: as far as the skin gave way, so that rounding does not part them.
  if (is_ahead_of_tip(needle_, line.along(place(state_.hole.front(), step)))) {
    state_ = {};
    if (!enter(step, line)) return;
  }
  if (state_.through) return;
  state_.slip = std::max(state_.slip, line.along(place(state_.hole.back(), step)));
  if (!state_.punctured && state_.slip < needle_.radius) return;
  if (state_.punctured && state_.slip < spread_) return;
  gives_way_ = pressed && !state_.punctured && bears(state_.hole.front()) < needle_.puncture;
  state_.punctured = true;
  lengthen(step, line);
}

}  // namespace phymul
