// SPDX-License-Identifier: MIT
#include "needle_path.h"

#include <phymul/bodies.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/outer_faces.h"
#include "scene/tool_state.h"

namespace phymul {
namespace {

/// Share of a triangle's side by which it is taken to be larger: a way along a line of the mesh must not pass between
/// two triangles by rounding.
constexpr double overlap = 1e-9;
constexpr double farthest_surface = 10.0;  // m from the tip
/// Least over largest eigenvalue of the moments below which particles lie in a plane, or all but.
constexpr double flattest = 1e-4;

/// Weights of the particles within `support_radius` of a point, whose sum is 1 and whose weighted mean place is the
/// point itself: moving least squares with a linear basis, (1 - (r / support_radius)^2)^2 as weight function. So a
/// force given to a point has the sum and the torque it has there. Empty where the particles around do not span space.
NeedleNode spread_weights(const PredictedStep& step, std::span<const Index> around, const Vec3& x,
                          double support_radius) {
  NeedleNode node;
  std::vector<Eigen::Vector4d> basis;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (const Index i : around) {
    const Vec3 d = (step.position(i) - x) / support_radius;
    const double inside = 1.0 - d.squaredNorm();
    if (!(inside > 0.0)) continue;
    node.particles.push_back(i);
    node.weights.push_back(inside * inside);
    basis.emplace_back(1.0, d.x(), d.y(), d.z());
    moments += node.weights.back() * basis.back() * basis.back().transpose();
  }
  // In two steps, without eigenvectors: the constructor that does both takes far longer to compile.
  const Eigen::Tridiagonalization<Eigen::Matrix4d> tridiagonal(moments);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> spectrum;
  spectrum.computeFromTridiagonal(tridiagonal.diagonal(), tridiagonal.subDiagonal(), Eigen::EigenvaluesOnly);
  const bool spans = node.particles.size() >= 4 && spectrum.eigenvalues()[0] > flattest * spectrum.eigenvalues()[3];
  if (!spans) return {};
  const Eigen::Vector4d coefficients = moments.ldlt().solve(Eigen::Vector4d::UnitX());
  for (std::size_t k = 0; k < basis.size(); ++k) node.weights[k] *= coefficients.dot(basis[k]);
  return node;
}

/// Whether the line from `from` along a unit vector goes through the triangle, and after which way. (T. Moeller, B.
/// Trumbore, J. Graphics Tools 2 (1997) 21-28.) `facing`: > 0 where the triangle's outside looks along the direction.
bool goes_through(const std::array<Vec3, 3>& t, const Vec3& from, const Vec3& direction, double& way, double& facing) {
  const Vec3 e1 = t[1] - t[0], e2 = t[2] - t[0], p = direction.cross(e2);
  const double determinant = e1.dot(p);
  facing = -determinant;
  if (determinant == 0.0) return false;
  const Vec3 s = from - t[0], q = s.cross(e1);
  const double u = s.dot(p) / determinant, v = direction.dot(q) / determinant;
  if (u < -overlap || v < -overlap || u + v > 1.0 + overlap) return false;
  way = e2.dot(q) / determinant;
  return true;
}

/// m along the line, where it meets the plane of the triangle: once at most where it is straight.
int meets_plane(const std::array<Vec3, 3>& t, const ShaftLine& line, std::array<double, 2>& along) {
  if (line.arc_radius() == 0.0) return 1;  // at 0: goes_through() finds the way from there
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]), n = line.turn().conjugate() * normal;
  const double apart = normal.dot(line.centre() - t[0]) / line.arc_radius(), most = std::hypot(n.x(), n.z());
  if (!(std::abs(apart) <= most) || most == 0.0) return 0;
  const double from = std::atan2(n.x(), n.z()), by = std::asin(-apart / most);
  for (int k = 0; k < 2; ++k) {
    along[k] = line.along(line.place(line.arc_radius() * (k == 0 ? from + by : from + std::numbers::pi - by)));
  }
  return 2;
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
  crossings_.reserve(64);
  sides_.resize(model.rest.size());
  follow_body(model);
}

void NeedlePath::follow_body(const Model& model) {
  facets_ = outward_triangles(model);
  surface_.clear();
  for (const auto& t : facets_) surface_.insert(surface_.end(), t.begin(), t.end());
  std::ranges::sort(surface_);
  surface_.erase(std::ranges::unique(surface_).begin(), surface_.end());
  body_of_.assign(model.mass.size(), 0);
  std::int32_t body = 0;
  for (const ConnectedBody& own : connected_bodies(model)) {
    for (const Index i : own.particles) body_of_[i] = body;
    ++body;
  }
  for (std::size_t i = 0; i < body_of_.size(); ++i) body_of_[i] = model.mass[i] == 0.0 ? -1 : body_of_[i];
  let_go_of_removed();
  needle_bearing(model, factors_, bearing_);
}

void NeedlePath::let_go_of_removed() {
  std::vector<NeedleNode> left;
  for (NeedleNode& node : state_.hole) {
    if (std::ranges::all_of(node.particles, [&](Index i) { return body_of_[i] >= 0; })) {
      left.push_back(std::move(node));
    } else if (node.out && !left.empty()) {
      left.back().out = true;
    }
  }
  const bool ends = left.size() != state_.hole.size() && !left.empty() && left.back().out;
  if (ends) state_.punctured = state_.through = true;
  state_.hole = std::move(left);
  if (state_.hole.empty()) forget();
}

void NeedlePath::restore(NeedleState state) {
  state_ = std::move(state);
  if (state_.through && !state_.hole.empty()) state_.hole.back().out = true;  // files written before have no mark
  let_go_of_removed();
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

/// Of particles of one body: forces on a wound's edge are none of the other's.
NeedleNode NeedlePath::node_at(const PredictedStep& step, const Vec3& x, std::int32_t body) {
  NeedleNode node;
  if (!x.allFinite()) return node;
  double support_radius = support_radius_;
  bool all = false;
  do {
    found_.clear();
    step.find({.low = x - Vec3::Constant(support_radius), .high = x + Vec3::Constant(support_radius)}, found_);
    all = found_.size() >= body_of_.size();
    std::erase_if(found_, [&](Index i) { return body_of_[i] != body; });
    std::ranges::sort(found_);
    node = spread_weights(step, found_, x, support_radius);
    support_radius *= 1.5;
  } while (node.particles.empty() && !all);
  return node;
}

/// On which sides of the box around a part of the shaft each particle of the surface is: what is on one side with all
/// its corners does not meet the shaft (D. Cohen and I. Sutherland's outcodes). Most of a surface is away from it.
void NeedlePath::look_around_shaft(const PredictedStep& step, const ShaftLine& line, double from, double to) {
  const bool straight = line.arc_radius() == 0.0;
  const int pieces = straight ? 1 : 8;
  Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
  for (int k = 0; k <= pieces; ++k) {
    const Vec3 x = line.place(from + (to - from) * k / pieces);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double off = straight ? 0.0 : line.arc_radius() * (1.0 - std::cos(0.5 * (to - from) / 8 / line.arc_radius()));
  const double more = off + 1e-6 * needle_.length;  // than arcs leave their chords, and rounding and `overlap`
  low.array() -= more;
  high.array() += more;
  for (const Index i : surface_) {
    const Vec3 x = step.position(i);
    unsigned sides = 0;
    for (int a = 0; a < 3; ++a) sides |= (x[a] < low[a] ? 1u : 0u) << a | (x[a] > high[a] ? 8u : 0u) << a;
    sides_[i] = static_cast<std::uint8_t>(sides);
  }
}

/// In order of Crossing::along.
const std::vector<NeedlePath::Crossing>& NeedlePath::crossings(const PredictedStep& step, const ShaftLine& line,
                                                               double from, double to) {
  crossings_.clear();
  look_around_shaft(step, line, from, to);
  for (const auto& row : facets_) {
    if ((sides_[row[0]] & sides_[row[1]] & sides_[row[2]]) != 0) continue;
    const std::array<Vec3, 3> t = corners(row, step);
    std::array<double, 2> at{};
    const int count = meets_plane(t, line, at);
    for (int k = 0; k < count; ++k) {
      double way = 0.0, facing = 0.0;
      if (!goes_through(t, line.place(at[k]), line.axis(at[k]), way, facing)) continue;
      const double along = at[k] + way;
      if (along >= from && along <= to) crossings_.push_back({along, facing > 0.0, body_of_[row[0]]});
    }
  }
  std::ranges::sort(crossings_, {}, &Crossing::along);
  return crossings_;
}

Vec3 NeedlePath::shaft_at(const ShaftLine& line, double along) const {
  Vec3 straight = line.place(along);
  if (state_.shaft.empty()) return straight;
  return straight + line.turn() * shaft_deflection(needle_, state_.shaft, along);
}

/// As the shaft is bent up to a spread from the tip.
ShaftLine NeedlePath::near_tip(const ShaftLine& line) const {
  if (state_.shaft.empty()) return line;
  const Vec3 tip = shaft_at(line, 0.0);
  return {tip, (shaft_at(line, std::min(spread_, needle_.length)) - tip).normalized()};
}

void NeedlePath::forget() {
  state_ = {.free = state_.free};
}

std::size_t NeedlePath::last_hole() const {
  std::size_t k = state_.hole.size() - 1;
  while (k > 0 && !state_.hole[k - 1].out) --k;
  return k;
}

bool NeedlePath::add_node(const PredictedStep& step, const Vec3& x, std::int32_t body) {
  NeedleNode node = node_at(step, x, body);
  if (node.particles.empty()) return false;
  state_.hole.push_back(std::move(node));
  return true;
}

/// True where the shaft has come through the surface: a hole begins there.
bool NeedlePath::enter(const PredictedStep& step, const ShaftLine& line) {
  const ShaftLine near = near_tip(line);
  double to = needle_.length;
  if (state_.through) to = near.along(place(state_.hole.back(), step)) - needle_.radius;
  if (!(to > 0.0)) return false;
  Crossing farthest{.along = -1.0};  // from the tip
  for (const Crossing& crossing : crossings(step, near, 0.0, to)) {
    if (crossing.outward) farthest = crossing;
  }
  if (farthest.along < 0.0) return false;
  if (state_.hole.empty()) forget();
  if (!add_node(step, near.place(farthest.along), farthest.body)) return false;
  state_.punctured = state_.through = false;
  state_.slip = farthest.along;
  return true;
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

/// The skin may have slid aside under the tip, which goes in where it is now.
void NeedlePath::enter_at_tip(const PredictedStep& step, const ShaftLine& line) {
  const std::size_t skin = last_hole();
  if (!add_node(step, shaft_at(line, state_.slip), body_of_[state_.hole[skin].particles.front()])) return;
  state_.hole.erase(state_.hole.begin() + static_cast<std::ptrdiff_t>(skin));
}

/// On the way that the tip has made since the last one, down to a place.
void NeedlePath::add_nodes(const PredictedStep& step, const ShaftLine& line, double until) {
  const std::int32_t body = body_of_[state_.hole.back().particles.front()];
  // A state from a file may have a longer way than a shaft.
  for (double left = std::min(state_.slip, needle_.length) - spread_; left > until; left -= spread_) {
    add_node(step, shaft_at(line, left), body);
  }
}

/// True where the tip has reached the surface from inside: the hole ends there.
bool NeedlePath::come_out(const PredictedStep& step, const ShaftLine& line) {
  const ShaftLine near = near_tip(line);
  const std::int32_t body = body_of_[state_.hole.back().particles.front()];
  // A mean over particles may be on the other side of the surface.
  const double to = std::min(state_.slip + 0.5 * spread_, near.along(place(state_.hole[last_hole()], step)));
  double exit = -1.0;
  for (const Crossing& crossing : crossings(step, near, 0.0, to)) {
    if (!crossing.outward && crossing.body == body) exit = crossing.along;
  }
  if (exit < 0.0) return false;
  add_nodes(step, line, exit);
  add_node(step, near.place(exit), body);
  state_.hole.back().out = true;
  state_.through = needle_.leaving <= needle_.cutting || exit >= needle_.radius;
  state_.slip = state_.through ? 0.0 : exit;
  return true;
}

void NeedlePath::lengthen(const PredictedStep& step, const ShaftLine& line) {
  const bool first = last_hole() + 1 == state_.hole.size();
  const std::int32_t body = body_of_[state_.hole.back().particles.front()];
  add_nodes(step, line, 0.0);
  state_.slip = 0.0;
  // Out again where the nearest surface back along the shaft is one it came out of. A mean over particles lies above
  // the deepest point of a dent, so that right after the puncture the tip may still be in front of the facets.
  const ShaftLine near = near_tip(line);
  const double far = std::min(0.5 * near.round(), farthest_surface);
  const auto behind = crossings(step, near, 0.0, far);
  const auto body_is_ahead = [&] {
    const auto& ahead = crossings(step, near, -far, 0.0);
    return !ahead.empty() && !ahead.back().outward;
  };
  const bool in = !behind.empty() ? behind.front().outward : first || body_is_ahead();
  if (in) {
    add_node(step, near.place(0.0), body);
    return;
  }
  state_.through = true;
  if (!behind.empty()) add_node(step, near.place(behind.front().along), body);
  state_.hole.back().out = true;
}

/// What has passed the tail is the thread's.
void NeedlePath::pass_tail(const PredictedStep& step, const ShaftLine& line, bool placed) {
  passed_.clear();
  std::vector<NeedleNode>& hole = state_.hole;
  const bool was_empty = hole.empty();
  while (!hole.empty()) {
    const Vec3 x = place(hole.front(), step);
    const double along = line.along(x);
    // What is just behind the tail of a placed one it may have passed in the step before.
    const bool jumped = placed && along > needle_.length + spread_;
    if (!jumped && (!(along > needle_.length) || (hole.size() == 1 && !state_.through))) return;
    if (!jumped) passed_.push_back({{.particles = hole.front().particles, .weights = hole.front().weights}, x});
    hole.erase(hole.begin());
  }
  if (!was_empty) forget();
}

/// True where the tip has left a hole the way it came: as far as the skin gave way, so that rounding does not part
/// them.
bool NeedlePath::withdraw(const PredictedStep& step, const ShaftLine& line) {
  std::vector<NeedleNode>& hole = state_.hole;
  if (hole.empty() || !is_ahead_of_tip(needle_, line.along(place(hole[last_hole()], step)))) return false;
  hole.resize(last_hole());
  if (hole.empty()) {
    forget();
  } else {
    state_.punctured = state_.through = true;
    state_.slip = 0.0;
  }
  return true;
}

void NeedlePath::follow(const TouchedParticles& touched, const ShaftLine& line, bool placed) {
  const PredictedStep& step = touched.step();
  pass_tail(step, line, placed);
  const bool pressed = !state_.hole.empty() && !state_.through;
  while (withdraw(step, line)) {
  }
  if ((state_.hole.empty() || state_.through) && !enter(step, line)) return;
  const double slip = line.along(place(state_.hole.back(), step));
  const bool advances = slip > state_.slip;
  state_.slip = std::max(state_.slip, slip);
  if (state_.punctured && state_.hole.back().out) {
    if (state_.slip < needle_.radius) return;
    gives_way_ = pressed && bears(state_.hole.back()) < needle_.leaving;
    state_.through = true;
    return;
  }
  if (!state_.punctured) {
    if (state_.slip < needle_.radius) return;
    gives_way_ = pressed && bears(state_.hole.back()) < needle_.puncture;
    state_.punctured = true;
    enter_at_tip(step, line);
    if (!come_out(step, line)) lengthen(step, line);
    return;
  }
  if (advances && come_out(step, line)) return;
  if (state_.slip >= spread_) lengthen(step, line);
}

}  // namespace phymul
