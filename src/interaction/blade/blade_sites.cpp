// SPDX-License-Identifier: MIT
//
// Where tissue is for a blade: the tetrahedra and the triangles of walls of a body, with what cuts have made of them.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "blade_edge.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

constexpr double points_in_spacing = 4.0;
constexpr double most_points = 1e4;  // so that an edge of any length has room

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

}  // namespace phymul
