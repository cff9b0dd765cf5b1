// SPDX-License-Identifier: MIT
#include "blade_edge.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

namespace phymul {
namespace {

constexpr int edge_sweeps = 4;
constexpr double points_in_spacing = 4.0;
constexpr double most_points = 1e4;  // so that an edge of any length has room
/// Spacings: tissue that is farther from its point of the edge, aside or behind, has been left.
constexpr double left_behind = 1.0;
constexpr int farthest_walk = 30;  // sites
/// Spacings from the edge to tissue that is not cut, and of a search for it.
constexpr double farthest_front = 1.0, front_step = 0.1;

}  // namespace

BladeEdge::BladeEdge(const Blade& blade, const Model& model) : blade_(blade), curve_(blade), model_(model) {
  // Without resistance there is nothing to hold.
  if (blade.toughness > 0.0 || has_sides()) build();
  if (has_sides() && !sites_.empty()) lay_out_sides();
}

void BladeEdge::build() {
  double volume = 0.0;
  std::map<std::array<Index, 3>, std::pair<Index, int>> faces;
  rows_ = static_cast<Index>(model_.cells.size());
  site_of_row_.assign(model_.cells.size(), -1);
  for (Index row = 0; row < rows_; ++row) {
    const Cell& cell = model_.cells[row];
    if (cell.type != CellType::tetrahedron) continue;
    const Key key = key_of(cell);
    sites_at_.resize(place_at_.size());
    if (const Index known = site_of(key); known >= 0) {
      // Rows of cuts go when these are undone: follow_body() has them.
      if (!cell.cuts.empty()) rows_ = row;
      if (cell.cuts.empty()) sites_[known].further.push_back(row);
      continue;
    }
    const auto site = static_cast<Index>(sites_.size());
    sites_.push_back({row, key});
    site_of_row_[row] = site;
    std::array<Vec3, 4> x;
    for (std::size_t v = 0; v < 4; ++v) x[v] = model_.rest[cell.particles[v]];
    volume += std::abs((x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0])) / 6.0;
    for (std::size_t v = 0; v < 4; ++v) {
      const Index own = place_of(cell.particles[v]);
      sites_at_[own].push_back(site);
      for (std::size_t w = 0; w < v; ++w) longest_ = std::max(longest_, (x[v] - x[w]).norm());
      std::array<Index, 3> face{};
      std::ranges::copy_if(key, face.begin(), [&](Index place) { return place != own; });
      const auto [other, is_first] = faces.try_emplace(face, site, static_cast<int>(v));
      if (is_first) continue;
      sites_[site].beyond[v] = other->second.first;
      sites_[other->second.first].beyond[other->second.second] = site;
    }
  }
  if (sites_.empty()) return;
  spacing_ = std::cbrt(volume / static_cast<double>(place_at_.size()));
  count_ = static_cast<Index>(std::clamp(std::ceil(points_in_spacing * curve_.length() / spacing_), 1.0, most_points));
  follow_body();
}

Index BladeEdge::place_of(Index particle) {
  const Vec3& rest = model_.rest[particle];
  place_of_.resize(model_.rest.size(), -1);
  Index& place = place_of_[particle];
  // A copy has been that of another particle before.
  if (place >= 0 && rest_[place] == rest) return place;
  const auto [at, is_new] = place_at_.try_emplace({rest.x(), rest.y(), rest.z()}, static_cast<Index>(place_at_.size()));
  if (is_new) rest_.push_back(rest);
  return place = at->second;
}

Index BladeEdge::site_of(const Key& key) const {
  if (key[0] >= static_cast<Index>(sites_at_.size())) return -1;
  const auto known = std::ranges::find(sites_at_[key[0]], key, [&](Index site) { return sites_[site].key; });
  return known == sites_at_[key[0]].end() ? -1 : *known;
}

BladeEdge::Key BladeEdge::key_of(const Cell& cell) {
  Key key{};
  std::ranges::transform(cell.particles, key.begin(), [&](Index i) { return place_of(i); });
  std::ranges::sort(key);
  return key;
}

void BladeEdge::begin_call() {
  looks_ = true;
}

void BladeEdge::accept() {
  points_ = next_;
  for (Side& side : sides_) side.now = side.next;
  looks_ = false;
}

void BladeEdge::follow_body() {
  if (sites_.empty()) return;
  for (const Index site : divided_) std::erase_if(sites_[site].further, [&](Index row) { return row >= rows_; });
  for (Index row = rows_; row < static_cast<Index>(model_.cells.size()); ++row) {
    const Index known = site_of(key_of(model_.cells[row]));
    if (known < 0) continue;
    sites_[known].further.push_back(row);
    divided_.push_back(known);
  }
  std::ranges::sort(divided_);
  const auto again = std::ranges::unique(divided_);
  divided_.erase(again.begin(), again.end());
}

bool BladeEdge::has_tissue(const Site& site) const {
  bool any = false;
  each_part(site, [&](const auto&) { any = true; });
  return any;
}

bool BladeEdge::is_whole(const Site& site) const {
  return site.further.empty() && model_.cells[site.row].share > 0.0 && model_.cells[site.row].cuts.empty();
}

BladeEdge::Weights BladeEdge::weights_in(const Corners& corners, const Vec3& x) {
  Mat3 edges;
  edges << corners[1] - corners[0], corners[2] - corners[0], corners[3] - corners[0];
  const Vec3 along = edges.inverse() * (x - corners[0]);
  return {1.0 - along.sum(), along.x(), along.y(), along.z()};
}

Index BladeEdge::walk(const TouchedParticles& touched, Index site, const Vec3& x, Weights& weights) const {
  for (int step = 0; step < farthest_walk && site >= 0 && has_tissue(sites_[site]); ++step) {
    weights = weights_in(corners_of(sites_[site], [&](Index i) { return touched.end(i); }), x);
    Eigen::Index least = 0;
    const double smallest = weights.minCoeff(&least);
    if (smallest >= in_site) return site;
    if (!std::isfinite(smallest)) return -1;
    site = sites_[site].beyond[static_cast<std::size_t>(least)];
  }
  return -1;
}

/// Takes the first tissue from the edge on that is whole: a cut is ahead of the edge by a part of a cell. None: site
/// -1.
void BladeEdge::go_on(const TouchedParticles& touched, const Vec3& edge, const Vec3& way, Point& point) const {
  for (int k = 0; k * front_step <= farthest_front; ++k) {
    point.ahead = k * front_step * spacing_;
    const Index site = walk(touched, point.site, edge + point.ahead * way, point.front);
    if (site < 0 || !is_whole(sites_[site])) continue;
    point.site = site;
    return;
  }
  point.site = -1;
}

/// At its limit the edge moves through the tissue by `by`, m. What it holds moves by half of that, so that the edge
/// comes nearer to it, or by all of it where the nearer tissue is cut.
void BladeEdge::slide(const TouchedParticles& touched, const Vec3& edge, const Vec3& way, double by,
                      Point& point) const {
  for (const double ahead : {std::max(0.0, point.ahead - 0.5 * by), point.ahead}) {
    Weights front;
    const Index site = walk(touched, point.site, edge + ahead * way, front);
    if (site < 0 || !is_whole(sites_[site])) continue;
    point.site = site;
    point.front = front;
    point.ahead = ahead;
    return;
  }
  go_on(touched, edge, way, point);
}

std::vector<BladePoint> BladeEdge::state() const {
  std::vector<BladePoint> state;
  for (const Point& point : points_) {
    const Weights& w = point.front;
    state.push_back(
        {point.place, sites_[point.site].row, {w[0], w[1], w[2], w[3]}, along(point.place), point.ahead, point.slides});
  }
  add_sides(state);
  return state;
}

void BladeEdge::restore(const std::vector<BladePoint>& state) {
  points_.clear();
  for (Side& side : sides_) side.now = {};
  for (const BladePoint& point : state) {
    const Index most = count_ + static_cast<Index>(sides_.size());
    const bool known = point.cell >= 0 && point.cell < rows_ && point.place >= 0 && point.place < most;
    const Index site = known ? site_of_row_[point.cell] : -1;
    if (site < 0) continue;
    const Weights weights(point.weights.data());
    if (point.place >= count_) {
      sides_[point.place - count_].now = {site, weights};
      continue;
    }
    points_.push_back({point.place, site, weights, point.ahead, point.slides});
  }
  next_ = points_;
}

double BladeEdge::along(Index place) const {
  return curve_.length() * ((place + 0.5) / count_ - 0.5);
}

Vec3 BladeEdge::edge_at(const ToolFrame& frame, Index place) const {
  return frame.outside(curve_.at(along(place)));
}

Vec3 BladeEdge::way_at(const ToolFrame& frame, Index place) const {
  return frame.turn * curve_.way(along(place));
}

/// Points that hold none take the tissue that they are in, where it is whole, or the next one ahead where it is cut.
void BladeEdge::find_tissue(const TouchedParticles& touched, const ToolFrame& end) {
  if (!looks_ || static_cast<Index>(next_.size()) == count_) return;
  Vec3 low = edge_at(end, 0), high = low;
  for (Index place = 1; place < count_; ++place) {
    low = low.cwiseMin(edge_at(end, place));
    high = high.cwiseMax(edge_at(end, place));
  }
  look_around(touched, low, high);
  const std::size_t held = next_.size();
  for (Index place = 0; place < count_ && !near_.empty(); ++place) {
    const auto known =
        std::ranges::find(next_.begin(), next_.begin() + static_cast<std::ptrdiff_t>(held), place, &Point::place);
    if (known != next_.begin() + static_cast<std::ptrdiff_t>(held)) continue;
    const Vec3 edge = edge_at(end, place), ahead = farthest_front * spacing_ * way_at(end, place);
    Point point{.place = place};
    bool in_tissue = false;
    double least = HUGE_VAL;  // share of the way ahead
    for (const Near& near : near_) {
      if ((edge.cwiseMax(edge + ahead).array() < near.low.array()).any() ||
          (edge.cwiseMin(edge + ahead).array() > near.high.array()).any()) {
        continue;
      }
      const Weights here = weights_in(near.corners, edge), there = weights_in(near.corners, edge + ahead);
      in_tissue = in_tissue || here.minCoeff() >= in_site;
      if (!is_whole(sites_[near.site])) continue;
      // Where all coordinates are above 0 on the way.
      double from = 0.0, to = 1.0;
      for (Eigen::Index v = 0; v < 4; ++v) {
        if (here[v] < 0.0 && there[v] <= here[v]) to = -1.0;
        const double at = here[v] / (here[v] - there[v]);
        if (here[v] < 0.0 && there[v] > here[v]) from = std::max(from, at);
        if (here[v] >= 0.0 && there[v] < 0.0) to = std::min(to, at);
      }
      if (from > to || from >= least) continue;
      least = from;
      point.site = near.site;
      point.front = here + from * (there - here);
      point.ahead = from * farthest_front * spacing_;
    }
    if (in_tissue && point.site >= 0) next_.push_back(point);
  }
  if (next_.size() > held) std::ranges::sort(next_, {}, &Point::place);
}

/// near_: sites with tissue around a box.
void BladeEdge::look_around(const TouchedParticles& touched, const Vec3& low, const Vec3& high) {
  near_.clear();
  found_.clear();
  touched.step().find({.low = low.array() - longest_, .high = high.array() + longest_}, found_);
  around_.clear();
  for (const Index i : found_) {
    const Index place = place_of(i);
    if (place >= static_cast<Index>(sites_at_.size())) continue;
    around_.insert(around_.end(), sites_at_[place].begin(), sites_at_[place].end());
  }
  std::ranges::sort(around_);
  const auto again = std::ranges::unique(around_);
  around_.erase(again.begin(), again.end());
  for (const Index site : around_) {
    if (!has_tissue(sites_[site])) continue;
    Near near{.site = site, .corners = corners_of(sites_[site], [&](Index i) { return touched.end(i); })};
    for (const Vec3& corner : near.corners) {
      near.low = near.low.cwiseMin(corner);
      near.high = near.high.cwiseMax(corner);
    }
    near_.push_back(near);
  }
}

/// The particles that the point of a site with these weights is a mean of; false: no tissue is left there.
bool BladeEdge::take_corners(TouchedParticles& touched, const Site& site, const Weights& weights,
                             Acting& acting) const {
  acting.corners.clear();
  double parts = 0.0;
  each_part(site, [&](const auto&) { parts += 1.0; });
  if (parts == 0.0) return false;
  each_part(site, [&](const std::vector<Index>& particles) {
    for (std::size_t v = 0; v < 4; ++v) {
      const std::size_t slot = touched.slot(particles[v]);
      const double weight = weights[static_cast<Eigen::Index>(v)] / parts;
      const auto known = std::ranges::find(acting.corners, slot, &std::pair<std::size_t, double>::first);
      if (known == acting.corners.end()) {
        acting.corners.emplace_back(slot, weight);
      } else {
        known->second += weight;
      }
    }
  });
  return true;
}

/// Whether it still holds its tissue.
bool BladeEdge::couple(TouchedParticles& touched, const Point& point, const ToolFrame& end, Acting& acting) const {
  const Site& site = sites_[point.site];
  const Vec3 way = acting.way = way_at(end, point.place);
  const double length = curve_.length() / count_ * curve_.stretch(along(point.place));  // m, of edge
  acting.limit = blade_.toughness * length * touched.dt();
  acting.front = edge_at(end, point.place) + point.ahead * way;
  if (!take_corners(touched, site, point.front, acting)) return false;
  Vec3 at = Vec3::Zero();
  acting.inverse_mass = acting.impulse = 0.0;
  for (const auto& [slot, weight] : acting.corners) {
    const TouchedParticles::Touched& particle = touched[slot];
    at += weight * particle.end(touched.dt());
    if (!particle.held)
      acting.inverse_mass += weight * weight * particle.inverse_mass * particle.free_part(way).squaredNorm();
  }
  return (acting.front - at).norm() <= left_behind * spacing_;
}

void BladeEdge::act(TouchedParticles& touched, const ToolPose& start, const ToolPose& pose, ToolForce& force) {
  if (sites_.empty()) return;
  const ToolFrame end(pose);
  pushed_.clear();
  if (blade_.toughness > 0.0) cut(touched, end, force);
  if (has_sides()) rub(touched, ToolFrame(start), end, force);
  std::ranges::sort(pushed_);
  force.particles += static_cast<int>(std::ranges::unique(pushed_).begin() - pushed_.begin());
}

void BladeEdge::cut(TouchedParticles& touched, const ToolFrame& end, ToolForce& force) {
  const double dt = touched.dt();
  next_ = points_;
  find_tissue(touched, end);
  acting_.resize(next_.size());
  std::size_t kept = 0;
  for (std::size_t k = 0; k < next_.size(); ++k) {
    if (!is_whole(sites_[next_[k].site])) {
      go_on(touched, edge_at(end, next_[k].place), way_at(end, next_[k].place), next_[k]);
    }
    if (next_[k].site < 0) continue;
    if (!couple(touched, next_[k], end, acting_[kept])) continue;
    next_[kept++] = next_[k];
  }
  next_.resize(kept);
  const auto push = [&](const Acting& acting, double impulse) {
    for (const auto& [slot, weight] : acting.corners) {
      if (!touched[slot].held) TouchedParticles::push(touched[slot], weight * impulse * acting.way);
    }
  };
  for (int sweep = 0; sweep < edge_sweeps; ++sweep) {
    for (std::size_t k = 0; k < kept; ++k) {
      Acting& acting = acting_[k];
      if (!(acting.inverse_mass > 0.0)) continue;
      double gap = acting.way.dot(acting.front);
      for (const auto& [slot, weight] : acting.corners) gap -= weight * acting.way.dot(touched[slot].end(dt));
      const double to = std::clamp(acting.impulse + gap / (dt * acting.inverse_mass), 0.0, acting.limit);
      push(acting, to - acting.impulse);
      acting.impulse = to;
    }
  }
  std::size_t left = 0;
  for (std::size_t k = 0; k < kept; ++k) {
    const Acting& acting = acting_[k];
    for (const auto& [slot, weight] : acting.corners) {
      const TouchedParticles::Touched& particle = touched[slot];
      if (acting.impulse == 0.0 || particle.held) continue;
      const Vec3 given = particle.free_part(weight * acting.impulse * acting.way);
      force.force -= given / dt;
      force.torque -= (particle.position - end.position).cross(given) / dt;
      pushed_.push_back(particle.particle);
    }
    Point& point = next_[k];
    point.slides = acting.impulse >= acting.limit;
    if (point.slides) {
      double by = acting.way.dot(acting.front);
      for (const auto& [slot, weight] : acting.corners) by -= weight * acting.way.dot(touched[slot].end(dt));
      slide(touched, edge_at(end, point.place), acting.way, std::max(0.0, by), point);
    }
    if (point.site >= 0) next_[left++] = point;
  }
  next_.resize(left);
}

}  // namespace phymul
