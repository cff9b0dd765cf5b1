// SPDX-License-Identifier: MIT
#include "blade_edge.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <utility>

namespace phymul {
namespace {

constexpr int edge_sweeps = 4;
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

void BladeEdge::begin_call() {
  looks_ = true;
}

void BladeEdge::accept() {
  points_ = next_;
  for (Side& side : sides_) side.now = side.next;
  looks_ = false;
}

Index BladeEdge::walk(const TouchedParticles& touched, Index site, const Vec3& x, const Vec3& line,
                      Weights& weights) const {
  for (int step = 0; step < farthest_walk && site >= 0 && has_tissue(sites_[site]); ++step) {
    const Site& own = sites_[site];
    weights = weights_in(own, corners_of(own, [&](Index i) { return touched.end(i); }), x, line);
    if (least_of(own, weights) >= in_site) return site;
    Eigen::Index least = 0;
    const double smallest = weights.head(static_cast<Eigen::Index>(own.corners())).minCoeff(&least);
    if (!std::isfinite(smallest) || smallest >= in_site) return -1;
    site = sites_[site].beyond[static_cast<std::size_t>(least)];
  }
  return -1;
}

/// Takes the first tissue from the edge on that is whole: a cut is ahead of the edge by a part of a cell. None: site
/// -1.
void BladeEdge::go_on(const TouchedParticles& touched, const Vec3& edge, const Vec3& way, Point& point) const {
  for (int k = 0; k * front_step <= farthest_front; ++k) {
    point.ahead = k * front_step * spacing_;
    const Index site = walk(touched, point.site, edge + point.ahead * way, point.line, point.front);
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
    const Index site = walk(touched, point.site, edge + ahead * way, point.line, front);
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
    const Site& site = sites_[point.site];
    const double last = site.thickness > 0.0 ? 0.0 : w[3];
    state.push_back({point.place, site.row, {w[0], w[1], w[2], last}, along(point.place), point.ahead, point.slides});
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

/// Along the edge, of unit length.
Vec3 BladeEdge::line_at(const ToolFrame& frame, Index place) const {
  return (frame.turn * curve_.normal(along(place)).cross(curve_.way(along(place)))).normalized();
}

/// Points that hold none take the tissue that they are in, where it is whole, or the next one ahead where it is cut.
void BladeEdge::find_tissue(const TouchedParticles& touched, const ToolFrame& end) {
  if (!looks_ || static_cast<Index>(next_.size()) == count_) return;
  Vec3 low = edge_at(end, 0), high = low;
  double farthest = 0.0;  // m
  for (Index place = 0; place < count_; ++place) {
    low = low.cwiseMin(edge_at(end, place));
    high = high.cwiseMax(edge_at(end, place));
    farthest = std::max(farthest, farthest_front * spacing_ * way_at(end, place).norm());
  }
  look_around(touched, low, high, farthest);
  const std::size_t held = next_.size();
  for (Index place = 0; place < count_ && !near_.empty(); ++place) {
    const auto known =
        std::ranges::find(next_.begin(), next_.begin() + static_cast<std::ptrdiff_t>(held), place, &Point::place);
    if (known != next_.begin() + static_cast<std::ptrdiff_t>(held)) continue;
    const Vec3 edge = edge_at(end, place), ahead = farthest_front * spacing_ * way_at(end, place);
    Point point{.place = place, .line = line_at(end, place)};
    bool in_tissue = false;
    double least = HUGE_VAL;  // share of the way ahead
    for (const Near& near : near_) {
      if ((edge.cwiseMax(edge + ahead).array() < near.low.array()).any() ||
          (edge.cwiseMin(edge + ahead).array() > near.high.array()).any()) {
        continue;
      }
      const Site& site = sites_[near.site];
      const Weights here = weights_in(site, near.corners, edge, point.line),
                    there = weights_in(site, near.corners, edge + ahead, point.line);
      in_tissue = in_tissue || (least_of(site, here) >= in_site && is_at(site, here));
      if (!is_whole(site)) continue;
      // Where all coordinates are above 0 on the way.
      double from = 0.0, to = 1.0;
      const auto stay_above = [&](double first, double last) {
        if (first < 0.0 && last <= first) to = -1.0;
        const double at = first / (first - last);
        if (first < 0.0 && last > first) from = std::max(from, at);
        if (first >= 0.0 && last < 0.0) to = std::min(to, at);
      };
      for (Eigen::Index v = 0; v < static_cast<Eigen::Index>(site.corners()); ++v) stay_above(here[v], there[v]);
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

/// near_: sites with tissue that may reach into a box, or come as near to it as `ahead`, m.
void BladeEdge::look_around(const TouchedParticles& touched, const Vec3& low, const Vec3& high, double ahead) {
  near_.clear();
  found_.clear();
  touched.step().find({.low = low.array() - longest_, .high = high.array() + longest_}, found_);
  around_.clear();
  for (const Index i : found_) {
    const Index place = place_of(i);
    if (place >= static_cast<Index>(sites_at_.size())) continue;
    for (const Index site : sites_at_[place]) {
      if (std::exchange(is_around_[site], 1) == 0) around_.push_back(site);
    }
  }
  std::ranges::sort(around_);
  for (const Index site : around_) {
    is_around_[site] = 0;
    if (!has_tissue(sites_[site])) continue;
    Near near{.site = site, .corners = corners_of(sites_[site], [&](Index i) { return touched.end(i); })};
    for (const Vec3& corner : near.corners) {
      near.low = near.low.cwiseMin(corner);
      near.high = near.high.cwiseMax(corner);
    }
    if (sites_[site].thickness > 0.0) {
      // An edge that leans comes to a place ahead of it elsewhere along itself.
      near.low.array() -= spacing_;
      near.high.array() += spacing_;
    }
    if ((near.low.array() > high.array() + ahead).any() || (near.high.array() < low.array() - ahead).any()) continue;
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
    for (std::size_t v = 0; v < particles.size(); ++v) {
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
  acting.limit = blade_.toughness * length_in(touched, site, point, length) * touched.dt();
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
  const Vec3 off = acting.front - at;
  if (site.thickness > 0.0) return std::abs(off.dot(way)) <= left_behind * spacing_;
  return off.norm() <= left_behind * spacing_;
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

/// m, of the edge in tissue at a point: in a wall its thickness, more where the edge leans.
double BladeEdge::length_in(const TouchedParticles& touched, const Site& site, const Point& point,
                            double of_edge) const {
  if (site.thickness == 0.0) return of_edge;
  const Corners corners = corners_of(site, [&](Index i) { return touched.end(i); });
  const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  constexpr double least = 0.1;  // an edge that lies in the wall cuts no more of it
  return site.thickness / std::max(std::abs(normal.dot(point.line)), least);
}

/// A wall goes along an edge that leans: what one point holds of it goes over to the next one. Beyond the ends it is
/// left.
void BladeEdge::follow_walls(const TouchedParticles& touched, const ToolFrame& end) {
  for (Point& point : next_) {
    const Site& site = sites_[point.site];
    point.line = line_at(end, point.place);
    if (site.thickness == 0.0 || !has_tissue(site)) continue;
    const Corners corners = corners_of(site, [&](Index i) { return touched.end(i); });
    const Weights off = weights_in(site, corners, edge_at(end, point.place), point.line);
    const Index place = std::abs(off[3]) < count_ ? point.place - points_to(off) : -1;
    if (place < 0 || place >= count_) point.site = -1;
    if (std::ranges::find(next_, place, &Point::place) == next_.end()) point.place = place;
  }
  std::erase_if(next_, [](const Point& point) { return point.site < 0; });
  std::ranges::sort(next_, {}, &Point::place);
}

void BladeEdge::cut(TouchedParticles& touched, const ToolFrame& end, ToolForce& force) {
  const double dt = touched.dt();
  next_ = points_;
  follow_walls(touched, end);
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
