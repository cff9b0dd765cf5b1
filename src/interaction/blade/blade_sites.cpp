// SPDX-License-Identifier: MIT
//
// Where tissue is for a blade: the tetrahedra and the triangles of walls of a body, with what cuts have made of them.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "blade_edge.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

constexpr double points_in_spacing = 4.0;
constexpr double most_points = 1e4;  // so that an edge of any length has room

// The sides of a blade: points on them resist the motion of the tissue that they are in, up to a force per area, in the
// surface that the edge has cut. What is at a point is the mean of what cuts have left of its cell.

constexpr int side_sweeps = 4;
constexpr double side_points_in_spacing = 2.0;
constexpr double most_side_points = 300.0;  // along each side, so that sides of any size have room

}  // namespace

void BladeEdge::build() {
  double volume = 0.0, area = 0.0;
  std::map<std::array<Index, 3>, std::pair<Index, int>> faces;
  site_of_row_.assign(model_.cells.size(), -1);
  for (Index row = 0; row < static_cast<Index>(model_.cells.size()); ++row) {
    const Cell& cell = model_.cells[row];
    const bool wall = is_of_wall(model_, cell);
    if (cell.type != CellType::tetrahedron && !wall) continue;
    const Key key = key_of(cell);
    sites_at_.resize(place_at_.size());
    if (const Index known = site_of(key); known >= 0) {
      sites_[known].further.push_back(row);
      continue;
    }
    const auto site = static_cast<Index>(sites_.size());
    rows_ = row + 1;
    sites_.push_back({row, key, wall ? model_.materials[cell.material].thickness : 0.0});
    site_of_row_[row] = site;
    const std::size_t corners = cell.particles.size();
    std::array<Vec3, 4> x;
    for (std::size_t v = 0; v < corners; ++v) x[v] = model_.rest[cell.particles[v]];
    const Vec3 across = (x[1] - x[0]).cross(x[2] - x[0]);
    (wall ? area : volume) += wall ? 0.5 * across.norm() : std::abs(across.dot(x[3] - x[0])) / 6.0;
    for (std::size_t v = 0; v < corners; ++v) {
      const Index own = place_of(cell.particles[v]);
      sites_at_[own].push_back(site);
      for (std::size_t w = 0; w < v; ++w) longest_ = std::max(longest_, (x[v] - x[w]).norm());
      std::array<Index, 3> face{};  // of a triangle an edge
      std::ranges::copy_if(key, face.begin(), [&](Index place) { return place != own; });
      const auto [other, is_first] = faces.try_emplace(face, site, static_cast<int>(v));
      if (is_first) continue;
      sites_[site].beyond[v] = other->second.first;
      sites_[other->second.first].beyond[other->second.second] = site;
    }
  }
  if (sites_.empty()) return;
  is_around_.assign(sites_.size(), 0);
  // Rows of cuts go when these are undone: follow_body() has those behind the last site.
  for (Site& site : sites_) std::erase_if(site.further, [&](Index row) { return row >= rows_; });
  const auto places = static_cast<double>(place_at_.size());
  spacing_ = volume > 0.0 ? std::cbrt(volume / places) : std::sqrt(area / places);
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
  Key key;
  key.fill(no_place);
  std::ranges::transform(cell.particles, key.begin(), [&](Index i) { return place_of(i); });
  std::ranges::sort(key);
  return key;
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

double BladeEdge::least_of(const Site& site, const Weights& weights) {
  return weights.head(static_cast<Eigen::Index>(site.corners())).minCoeff();
}

BladeEdge::Weights BladeEdge::weights_in(const Site& site, const Corners& corners, const Vec3& x,
                                         const Vec3& line) const {
  if (site.thickness > 0.0) {
    const Vec3 a = corners[1] - corners[0], b = corners[2] - corners[0], n = a.cross(b);
    const double off = n.dot(x - corners[0]) / n.dot(line);
    const Vec3 r = x - off * line - corners[0];
    const double to_b = r.cross(b).dot(n) / n.squaredNorm(), to_c = a.cross(r).dot(n) / n.squaredNorm();
    return {1.0 - to_b - to_c, to_b, to_c, off * count_ / curve_.length()};
  }
  Mat3 edges;
  edges << corners[1] - corners[0], corners[2] - corners[0], corners[3] - corners[0];
  const Vec3 along = edges.inverse() * (x - corners[0]);
  return {1.0 - along.sum(), along.x(), along.y(), along.z()};
}

void BladeEdge::lay_out_sides() {
  const auto points = [&](double length) {
    return static_cast<int>(std::clamp(std::ceil(side_points_in_spacing * length / spacing_), 1.0, most_side_points));
  };
  const int columns = points(curve_.length()), rows = points(blade_.height);
  side_rows_ = static_cast<std::size_t>(rows);
  for (int column = 0; column < columns; ++column) {
    const double along = curve_.length() * ((column + 0.5) / columns - 0.5);
    for (int row = 0; row < rows; ++row) {
      const Vec3 behind(0.0, 0.0, blade_.height * (row + 0.5) / rows);
      sides_.push_back({.place = curve_.at(along) + behind, .normal = curve_.normal(along)});
    }
  }
}

/// At the first step of a call: where points come into tissue. They do so from the edge on, or beside others.
void BladeEdge::find_sides(const TouchedParticles& touched, const ToolFrame& end) {
  const auto enter = [&](Side& side, Index from) {
    if (side.next.site >= 0 || from < 0 || sites_[from].thickness > 0.0) return;
    side.next.site = walk(touched, from, end.outside(side.place), Vec3::Zero(), side.next.at);
  };
  const std::size_t rows = side_rows_, count = sides_.size();
  for (const Point& point : next_) {
    const double column = (point.place + 0.5) / count_ * static_cast<double>(count / rows);
    enter(sides_[static_cast<std::size_t>(column) * rows], point.site);
  }
  if (blade_.toughness == 0.0 && std::ranges::all_of(sides_, [](const Side& side) { return side.next.site < 0; })) {
    look_for_sides(touched, end);
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (k % rows > 0) enter(sides_[k], sides_[k - 1].next.site);
    if (k >= rows) enter(sides_[k], sides_[k - rows].next.site);
  }
  for (std::size_t k = count; k-- > 0;) {
    if (k % rows + 1 < rows) enter(sides_[k], sides_[k + 1].next.site);
    if (k + rows < count) enter(sides_[k], sides_[k + rows].next.site);
  }
}

void BladeEdge::look_for_sides(const TouchedParticles& touched, const ToolFrame& end) {
  Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
  for (const Side& side : sides_) {
    low = low.cwiseMin(end.outside(side.place));
    high = high.cwiseMax(end.outside(side.place));
  }
  look_around(touched, low, high, spacing_);
  for (Side& side : sides_) {
    const Vec3 x = end.outside(side.place);
    for (const Near& near : near_) {
      if ((x.array() < near.low.array()).any() || (x.array() > near.high.array()).any()) continue;
      const Site& site = sites_[near.site];
      if (site.thickness == 0.0 && weights_in(site, near.corners, x, Vec3::Zero()).minCoeff() >= in_site)
        side.next.site = near.site;
      if (side.next.site >= 0) break;
    }
  }
}

void BladeEdge::add_sides(std::vector<BladePoint>& state) const {
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    const auto& [site, at] = sides_[k].now;
    if (site < 0) continue;
    const double behind = blade_.height * (static_cast<double>(k % side_rows_) + 0.5) / static_cast<double>(side_rows_);
    state.push_back({.place = count_ + static_cast<Index>(k),
                     .cell = sites_[site].row,
                     .weights = {at[0], at[1], at[2], at[3]},
                     .along = curve_.unrolled(sides_[k].place).x(),
                     .ahead = -behind});
  }
}

void BladeEdge::rub(TouchedParticles& touched, const ToolFrame& start, const ToolFrame& end, ToolForce& force) {
  const double dt = touched.dt();
  for (Side& side : sides_) side.next = side.now;
  if (looks_) find_sides(touched, end);
  for (Side& side : sides_) {
    auto& [site, at] = side.next;
    if (site >= 0) site = walk(touched, site, end.outside(side.place), Vec3::Zero(), at);
    side.impulse.setZero();
    if (site >= 0 && !take_corners(touched, sites_[site], at, side.acting)) site = -1;
    if (site < 0) continue;
    side.acting.inverse_mass = 0.0;
    for (const auto& [slot, weight] : side.acting.corners) {
      if (!touched[slot].held) side.acting.inverse_mass += weight * weight * touched[slot].inverse_mass;
    }
  }
  const double limit = blade_.friction * curve_.length() * blade_.height / static_cast<double>(sides_.size()) * dt;
  for (int sweep = 0; sweep < side_sweeps; ++sweep) {
    for (Side& side : sides_) {
      if (side.next.site < 0 || !(side.acting.inverse_mass > 0.0)) continue;
      Vec3 slip = (end.outside(side.place) - start.outside(side.place)) / dt;
      for (const auto& [slot, weight] : side.acting.corners) slip -= weight * touched[slot].velocity;
      const Vec3 normal = end.turn * side.normal;
      Vec3 to = side.impulse + (slip - normal.dot(slip) * normal) / side.acting.inverse_mass;
      if (const double size = to.norm(); size > limit) to *= limit / size;
      for (const auto& [slot, weight] : side.acting.corners) {
        TouchedParticles::Touched& particle = touched[slot];
        if (particle.held) continue;
        const Vec3 given = TouchedParticles::push(particle, weight * (to - side.impulse));
        force.force -= given / dt;
        force.torque -= (particle.position - end.position).cross(given) / dt;
      }
      side.impulse = to;
    }
  }
  for (const Side& side : sides_) {
    if (side.impulse == Vec3::Zero()) continue;
    for (const auto& [slot, weight] : side.acting.corners) {
      if (!touched[slot].held) pushed_.push_back(touched[slot].particle);
    }
  }
}

}  // namespace phymul
