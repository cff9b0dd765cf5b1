// SPDX-License-Identifier: MIT
#include "contact_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "base/union_find.h"
#include "model/cell_geometry.h"
#include "model/closed_surface.h"
#include "model/outer_faces.h"

namespace phymul {
namespace {

/// Adds one body: its particles by row of the model, and triangles with outward normals.
class SurfaceBuilder {
 public:
  /// `walls`: walls_beside_cells().
  SurfaceBuilder(const Model& model, ContactSurface& surface, std::span<const Index> walls)
      : model_(model), surface_(surface), slot_(model.rest.size(), -1) {
    for (const Index row : walls) walls_.push_back(key(model.cells[row].particles));
    std::ranges::sort(walls_);
  }

  /// The first `solid` of the facets are of volume cells.
  void add(std::span<const Facet> facets, Index body, std::size_t solid) {
    const std::size_t first = surface_.particles.size();
    edges_.clear();
    for (std::size_t k = 0; k < facets.size(); ++k) add(facets[k], body, k < solid);
    for (Index i = 0; facets.empty() && i < model_.particle_count(); ++i) {
      if (surface_.body_of[i] != body) continue;
      for (const Index* j = model_.neighbours.begin(i); j != model_.neighbours.end(i); ++j) add_edge(i, *j, body);
    }
    for (std::size_t k = 0; k < edges_.size(); ++k) {
      ContactSurface::Particle& particle = surface_.particles[first + k];
      particle.edge /= edges_[k];
      surface_.longest_edge = std::max(surface_.longest_edge, particle.edge);
    }
  }

  /// Of a body with cuts its part of the tissue's surface. Edges are those of cells, not of the pieces that a cut makes
  /// of their faces.
  void add_tissue(const TissueSurface& tissue, const VecList& place, Index body, bool solid) {
    const std::size_t first = surface_.particles.size();
    if (surface_.is_cut.size() <= static_cast<std::size_t>(body)) surface_.is_cut.resize(body + 1, 0);
    surface_.is_cut[body] = 1;
    std::vector<Index> slot(place.size(), -1);
    surface_.particles.reserve(first + place.size());
    surface_.rest.reserve(first + place.size());
    surface_.triangles.reserve(surface_.triangles.size() + tissue.triangles.size());
    for (std::size_t k = 0; k < place.size(); ++k) {
      const TissueVertex& at = tissue.vertices[k];
      if (surface_.body_of[at.particles[0]] != body) continue;
      slot[k] = static_cast<Index>(surface_.particles.size());
      surface_.particles.push_back(
          {.row = at.particles[1] < 0 ? at.particles[0] : -1, .body = body, .at = at, .shares = shares(at)});
      surface_.rest.push_back(place[k]);
    }
    std::vector<int> edges(surface_.particles.size(), 0);
    std::vector<char> on_both(edges.size(), 0);  // faces of a cut: where it ends
    for (std::size_t t = 0; t < tissue.triangles.size(); ++t) {
      const auto& corner = tissue.triangles[t];
      if (slot[corner[0]] < 0) continue;
      const Vec3 area = (place[corner[1]] - place[corner[0]]).cross(place[corner[2]] - place[corner[0]]);
      const double edge = cell_edge(tissue, corner);
      if (!(area.norm() > sliver * edge * edge)) continue;
      const bool of_cut = tissue.of_cut[t] != 0;
      for (const Index c : corner) {
        ContactSurface::Particle& own = surface_.particles[slot[c]];
        own.edge += edge;
        ++edges[slot[c]];
        if (!of_cut) continue;
        own.of_cut = true;
        if (area.dot(own.normal) < 0.0) on_both[slot[c]] = 1;
        own.normal += area;
      }
      surface_.longest_edge = std::max(surface_.longest_edge, edge);
      surface_.triangles.push_back({.corner = {slot[corner[0]], slot[corner[1]], slot[corner[2]]},
                                    .body = body,
                                    .edge = edge,
                                    .has_inside = solid && !is_of_wall(tissue, corner),
                                    .of_cut = of_cut,
                                    .normal = of_cut ? area.normalized() : Vec3(Vec3::Zero())});
    }
    for (std::size_t k = first; k < edges.size(); ++k) {
      ContactSurface::Particle& own = surface_.particles[k];
      own.edge /= std::max(edges[k], 1);
      own.normal = on_both[k] != 0 ? Vec3(Vec3::Zero()) : own.normal.normalized();
    }
  }

 private:
  /// Of the square of its edge: a triangle of less area is left out.
  static constexpr double sliver = 1e-9;

  std::array<double, 4> shares(const TissueVertex& at) const {
    constexpr double light = 0.3;  // of the heaviest
    std::array<double, 4> of = at.weights;
    if (model_.mass.empty()) return of;
    double heaviest = 0.0, sum = 0.0;
    for (std::size_t v = 0; v < 4 && at.particles[v] >= 0; ++v) {
      heaviest = std::max(heaviest, model_.mass[at.particles[v]]);
    }
    for (std::size_t v = 0; v < 4 && at.particles[v] >= 0; ++v) {
      of[v] *= std::min(1.0, model_.mass[at.particles[v]] / (light * heaviest));
      sum += of[v];
    }
    for (double& share : of) share /= sum;
    return of;
  }

  /// m: the longest between two of the particles that its corners are means of.
  double cell_edge(const TissueSurface& tissue, const std::array<Index, 3>& corner) const {
    std::array<Index, 12> particles{};
    std::size_t count = 0;
    for (const Index c : corner) {
      for (const Index i : tissue.vertices[c].particles) {
        if (i >= 0) particles[count++] = i;
      }
    }
    double longest = 0.0;
    for (std::size_t a = 1; a < count; ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        longest = std::max(longest, (model_.rest[particles[a]] - model_.rest[particles[b]]).squaredNorm());
      }
    }
    return std::sqrt(longest);
  }

  using Corners = std::array<Index, 3>;

  static Corners key(std::span<const Index> particles) {
    Corners own{particles[0], particles[1], particles[2]};
    std::ranges::sort(own);
    return own;
  }

  /// Whether its corners are means of the particles of a wall.
  bool is_of_wall(const TissueSurface& tissue, const std::array<Index, 3>& corner) const {
    if (walls_.empty()) return false;
    std::vector<Index> particles;
    for (const Index c : corner) {
      for (const Index i : tissue.vertices[c].particles) {
        if (i >= 0 && std::ranges::find(particles, i) == particles.end()) particles.push_back(i);
      }
    }
    return particles.size() == 3 && std::ranges::binary_search(walls_, key(particles));
  }

  Index slot(Index row, Index body) {
    if (slot_[row] < 0) {
      slot_[row] = static_cast<Index>(surface_.particles.size());
      surface_.particles.push_back({.row = row, .body = body, .at = {{row, -1, -1, -1}, {1.0}}});
      surface_.rest.push_back(model_.rest[row]);
      edges_.push_back(0);
    }
    return slot_[row];
  }

  double add_edge(Index a, Index b, Index body) {
    const double length = (model_.rest[a] - model_.rest[b]).norm();
    for (const Index i : {a, b}) {
      const auto own = static_cast<std::size_t>(slot(i, body));
      surface_.particles[own].edge += length;
      ++edges_[own - (surface_.particles.size() - edges_.size())];
    }
    return length;
  }

  void add(const Facet& facet, Index body, bool solid) {
    std::vector<Index> ring = facet.particles;
    double longest = 0.0;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Index next = ring[(k + 1) % ring.size()];
      if (next != ring[k]) longest = std::max(longest, add_edge(ring[k], next, body));
    }
    if (ring_area(ring, model_.rest).dot(facet.area) < 0.0) std::reverse(ring.begin(), ring.end());
    surface_.longest_edge = std::max(surface_.longest_edge, longest);
    for (std::size_t k = 2; k < ring.size(); ++k) {
      // Of cells with a corner twice: no area, and a contact would push one particle as two.
      if (ring[k - 1] == ring[k] || ring[k - 1] == ring[0] || ring[k] == ring[0]) continue;
      surface_.triangles.push_back({.corner = {slot(ring[0], body), slot(ring[k - 1], body), slot(ring[k], body)},
                                    .body = body,
                                    .edge = longest,
                                    .has_inside = solid});
    }
  }

  const Model& model_;
  ContactSurface& surface_;
  std::vector<Index> slot_;  // [N]
  std::vector<int> edges_;   // of the particles of the body at hand, at each
  std::vector<Corners> walls_;
};

/// What connected_bodies() finds once these cells have changed, from what it found before; nothing where the cells
/// alone do not tell. Bodies are as before if what each has of the particles of those cells, before and after, is
/// connected through them: a way that led through changed cells still leads there.
std::optional<BodyRows> rows_after(const Model& model, const ContactSurface& before, std::span<const Index> cells,
                                   std::vector<Index> particles, const OuterFaces& outer) {
  std::ranges::sort(particles);
  const auto again = std::ranges::unique(particles);
  particles.erase(again.begin(), again.end());
  UnionFind sets(particles.size());
  const auto place = [&](Index i) {
    return static_cast<Index>(std::ranges::lower_bound(particles, i) - particles.begin());
  };
  for (const Index row : cells) {
    const auto corners = outer.particles_of(row);
    for (const Index i : corners) sets.join(place(corners.front()), place(i));
  }
  BodyRows rows{before.body_of, before.bodies};
  std::vector<Index> body_of_set(particles.size(), -1), set_of_body(rows.count, -1);
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const Index body = rows.of[particles[k]], set = sets.root(static_cast<Index>(k));
    if (body < 0 || model.mass[particles[k]] == 0.0) continue;
    if (body_of_set[set] < 0 && set_of_body[body] < 0)
      std::tie(body_of_set[set], set_of_body[body]) = std::tuple(body, set);
    if (body_of_set[set] != body) return std::nullopt;
  }
  for (std::size_t k = 0; k < particles.size(); ++k) {
    const bool is_there = model.mass[particles[k]] > 0.0;
    rows.of[particles[k]] = is_there ? body_of_set[sets.root(static_cast<Index>(k))] : -1;
    if (is_there && rows.of[particles[k]] < 0) return std::nullopt;
  }
  Index next = 0;  // bodies are in order of their first particles
  for (const Index body : rows.of) {
    if (body > next) return std::nullopt;
    next += body == next ? 1 : 0;
  }
  return next == rows.count ? std::optional(std::move(rows)) : std::nullopt;
}

/// `outer`: of the model.
ContactSurface made_surface(const Model& model, const OuterFaces& outer, BodyRows rows) {
  ContactSurface surface;
  surface.body_of = std::move(rows.of);
  surface.bodies = rows.count;
  const std::vector<Index>& body_of = surface.body_of;
  struct Kind {
    bool of_cells = false, solid = false, cut = false;
  };
  std::vector<Kind> kind(rows.count);
  const auto kind_of = [&](Index particle) -> Kind* {  // none where all is removed
    return body_of[particle] < 0 ? nullptr : &kind[body_of[particle]];
  };
  outer.each_place([&](Index particle) {
    if (Kind* const own = kind_of(particle)) own->of_cells = true;
  });
  for (const Index row : outer.cut_cells()) {
    if (Kind* const own = kind_of(outer.particles_of(row).front())) own->cut = true;
  }
  for (Kind& own : kind) own.solid = own.of_cells && model.dimension == 3;
  if (has_walls(model)) {
    for (const Cell& cell : model.cells) {
      Kind* const own = cell.share > 0.0 && !cell.cuts.empty() ? kind_of(cell.particles.front()) : nullptr;
      if (own != nullptr) own->cut = true;
    }
  }
  std::vector<std::vector<Facet>> facets(rows.count);
  const auto add_facets = [&](bool of_cells, auto find) {
    std::vector<char> chosen(model.rest.size(), 0);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const Index body = body_of[i];
      chosen[i] = body >= 0 && !kind[body].cut && kind[body].of_cells == of_cells;
    }
    if (std::ranges::find(chosen, 1) == chosen.end()) return;
    for (Facet& facet : find(chosen)) facets[body_of[facet.particles[0]]].push_back(std::move(facet));
  };
  add_facets(true, [&](std::span<const char> chosen) { return facets_of_cells(model, chosen, outer); });
  std::vector<Index> walls;
  if (std::ranges::any_of(kind, &Kind::solid)) walls = walls_beside_cells(model, outer);
  std::vector<std::size_t> solid;
  for (Index body = 0; body < rows.count; ++body) solid.push_back(kind[body].solid ? facets[body].size() : 0);
  add_facets(true, [&](std::span<const char> chosen) { return facets_of_walls(model, chosen, walls); });
  add_facets(false, [&](std::span<const char> chosen) { return explicit_facets(model, chosen); });
  TissueSurface tissue;
  if (std::ranges::any_of(kind, &Kind::cut)) tissue = tissue_surface_of(model, outer);
  const VecList place = tissue.at(model.rest);
  SurfaceBuilder builder(model, surface, walls);
  for (Index body = 0; body < rows.count; ++body) {
    if (kind[body].cut) {
      builder.add_tissue(tissue, place, body, kind[body].solid);
    } else {
      builder.add(facets[body], body, solid[body]);
    }
  }
  if (!surface.is_cut.empty()) surface.is_cut.resize(rows.count, 0);
  return surface;
}

}  // namespace

ContactSurface make_contact_surface(const Model& model) {
  return made_surface(model, OuterFaces(model), body_rows(model));
}

std::shared_ptr<const ContactSurface> FollowedSurface::of(const Scene& scene) {
  if (made_ && body_version_ == scene.body_version()) return made_;
  BodyRows rows = follow(scene);
  made_ = std::make_shared<const ContactSurface>(made_surface(scene.model(), outer_, std::move(rows)));
  body_version_ = scene.body_version();
  return made_;
}

/// Updates outer_. What joins a body besides cells, lists of neighbours, does not count while it has cuts
/// (body_rows()).
BodyRows FollowedSurface::follow(const Scene& scene) {
  const Model& model = scene.model();
  const std::vector<Index>& cells = scene.changed_cells();
  if (!made_ || body_version_ + 1 != scene.body_version() || cells.empty() || has_walls(model)) {
    outer_.follow(model);
    return body_rows(model);
  }
  const bool had_cuts = !outer_.cut_cells().empty();
  std::vector<Index> particles;
  const auto add_particles = [&] {
    for (const Index row : cells) {
      const auto own = outer_.particles_of(row);
      particles.insert(particles.end(), own.begin(), own.end());
    }
  };
  add_particles();
  outer_.follow(model, cells);
  add_particles();
  std::optional<BodyRows> rows;
  if (had_cuts && !outer_.cut_cells().empty()) rows = rows_after(model, *made_, cells, std::move(particles), outer_);
  return rows ? std::move(*rows) : body_rows(model);
}

double ContactSurface::distance_at_rest(std::size_t particle_row, const Triangle& triangle) const {
  const Vec3 &a = rest[triangle.corner[0]], &b = rest[triangle.corner[1]], &c = rest[triangle.corner[2]];
  const Vec3 share = closest_point(rest[particle_row], a, b, c);
  return (rest[particle_row] - (share[0] * a + share[1] * b + share[2] * c)).norm();
}

double ContactSurface::skins(const Particle& particle, std::size_t particle_row, const Triangle& triangle,
                             double margin) const {
  const double usual = margin > 0.0 ? 2.0 * margin : usual_skin * (triangle.edge + particle.edge);
  if (!are_cut(particle, triangle)) return usual;
  return triangle.has_inside ? 0.0 : std::min(usual, distance_at_rest(particle_row, triangle));
}

/// A lip's point lies in the plane of the other lip's triangle at rest, or a little beside it where the cut is bent;
/// the other side of a strip between two cuts is behind it by the strip's thickness.
bool ContactSurface::are_lips(const Particle& particle, std::size_t particle_row, const Triangle& triangle) const {
  constexpr double facing = -0.5, parallel = -0.95;  // cosines
  constexpr double behind = 0.05, in_plane = 1e-3;   // of an edge
  if (!particle.of_cut || !triangle.of_cut) return false;
  const double cosine = particle.normal.dot(triangle.normal);
  if (!(cosine < facing)) return false;
  const auto& [a, b, c] = triangle.corner;
  const double ahead = triangle.normal.dot(rest[particle_row] - rest[a]) / triangle.edge;
  const double opposite = particle.normal.dot((rest[a] + rest[b] + rest[c]) / 3.0 - rest[particle_row]) / triangle.edge;
  // Of a bent cut one is behind the other. Where both are, tissue is between them, as in the angle of two cuts.
  const bool around_tissue = ahead < -in_plane && opposite < -in_plane;
  return ahead >= -(cosine < parallel ? behind : in_plane) && !around_tissue;
}

bool ContactSurface::is_own_skin(const Particle& particle, std::size_t particle_row, const Triangle& triangle) const {
  const double near = skin_factor * std::max(particle.edge, triangle.edge);
  const auto is_near = [&](Index corner) { return (rest[corner] - rest[particle_row]).squaredNorm() <= near * near; };
  if (particle.body == triangle.body && std::ranges::any_of(triangle.corner, is_near) &&
      !are_lips(particle, particle_row, triangle)) {
    return true;
  }
  // The rim of a cut lies on the outer triangles across it, and would be held there by them.
  constexpr double on_it = 1e-6;  // of an edge
  return particle.of_cut && !triangle.of_cut && are_cut(particle, triangle) &&
         distance_at_rest(particle_row, triangle) <= on_it * triangle.edge;
}

}  // namespace phymul
