// SPDX-License-Identifier: MIT
#include "contact_surface.h"

#include <phymul/bodies.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "model/surface_facets.h"

namespace phymul {
namespace {

/// Adds one body: its particles by row of the model, and triangles with outward normals.
class SurfaceBuilder {
 public:
  SurfaceBuilder(const Model& model, ContactSurface& surface) : model_(model), surface_(surface) {}

  void add(const Model& part, Index body, const std::vector<Index>& particles) {
    const bool solid =
        std::any_of(part.cells.begin(), part.cells.end(), [](const Cell& cell) { return is_volume(cell.type); });
    const std::vector<Facet> facets = surface_facets(part, std::vector<char>(part.rest.size(), 1));
    for (const Facet& facet : facets) add(facet, body, solid);
    if (facets.empty()) {
      for (const Index i : particles) {
        if (!model_.mass.empty() && model_.mass[i] == 0.0) continue;  // removed
        for (const Index* j = model_.neighbours.begin(i); j != model_.neighbours.end(i); ++j) add_edge(i, *j, body);
      }
    }
    for (const auto& [row, edges] : edges_) {
      ContactSurface::Particle& particle = surface_.particles[slot_[row]];
      particle.edge = edges.first / edges.second;
      surface_.longest_edge = std::max(surface_.longest_edge, particle.edge);
    }
    edges_.clear();
  }

 private:
  Index slot(Index row, Index body) {
    const auto [known, fresh] = slot_.try_emplace(row, static_cast<Index>(surface_.particles.size()));
    if (fresh) {
      surface_.particles.push_back({row, body, 0.0});
      surface_.rest.push_back(model_.rest[row]);
    }
    return known->second;
  }

  double add_edge(Index a, Index b, Index body) {
    const double length = (model_.rest[a] - model_.rest[b]).norm();
    for (const Index i : {a, b}) {
      slot(i, body);
      auto& [sum, count] = edges_[i];
      sum += length;
      ++count;
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
      surface_.triangles.push_back(
          {{slot(ring[0], body), slot(ring[k - 1], body), slot(ring[k], body)}, body, longest, solid});
    }
  }

  const Model& model_;
  ContactSurface& surface_;
  std::map<Index, Index> slot_;                    // by row of the model
  std::map<Index, std::pair<double, int>> edges_;  // sum of lengths, count
};

}  // namespace

ContactSurface make_contact_surface(const Model& model) {
  ContactSurface surface;
  SurfaceBuilder builder(model, surface);
  const std::vector<ConnectedBody> bodies = connected_bodies(model);
  std::vector<Index> body_of(model.rest.size(), -1);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (const Index i : bodies[b].particles) body_of[i] = static_cast<Index>(b);
  }
  std::vector<Model> parts(bodies.size());
  for (Model& part : parts) {
    part.dimension = model.dimension;
    part.rest = model.rest;
  }
  for (const Cell& cell : model.cells) {
    const Index body = cell.particles.empty() ? -1 : body_of[cell.particles.front()];  // none where all is removed
    if (cell_size(cell.type) > 0 && cell.share > 0.0 && body >= 0) parts[body].cells.push_back(cell);
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    builder.add(parts[b], static_cast<Index>(b), bodies[b].particles);
    parts[b] = {};
  }
  return surface;
}

bool ContactSurface::is_own_skin(const Particle& particle, std::size_t particle_row, const Triangle& triangle) const {
  if (particle.body != triangle.body) return false;
  const double near = skin_factor * std::max(particle.edge, triangle.edge);
  return std::any_of(triangle.corner.begin(), triangle.corner.end(),
                     [&](Index corner) { return (rest[corner] - rest[particle_row]).squaredNorm() <= near * near; });
}

}  // namespace phymul
