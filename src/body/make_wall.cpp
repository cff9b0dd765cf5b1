// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/wall.h>

#include <algorithm>
#include <map>
#include <string>

#include "base/decimal.h"
#include "model/cell_geometry.h"
#include "model/outer_faces.h"

namespace phymul {
namespace {

/// Sides may be longer than wanted by this factor: of triangles that are divided into four, lengths lie on both sides.
constexpr double longest_side = 1.4142;

constexpr const char* capsule_group = "phymul: a new capsule";  // while its triangles get their material

std::array<Index, 2> sorted_edge(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

double longest_of(const Surface& surface) {
  double longest = 0.0;
  for (const auto& t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, (surface.vertices[t[(k + 1) % 3]] - surface.vertices[t[k]]).norm());
    }
  }
  return longest;
}

/// Each triangle becomes four.
Surface divided(const Surface& surface) {
  Surface fine;
  fine.vertices = surface.vertices;
  std::map<std::array<Index, 2>, Index> middle;
  const auto middle_of = [&](Index a, Index b) {
    const auto [at, fresh] = middle.try_emplace(sorted_edge(a, b), static_cast<Index>(fine.vertices.size()));
    if (fresh) fine.vertices.push_back(0.5 * (surface.vertices[a] + surface.vertices[b]));
    return at->second;
  };
  for (const auto& [a, b, c] : surface.triangles) {
    const Index ab = middle_of(a, b), bc = middle_of(b, c), ca = middle_of(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return fine;
}

void require_valid(const Surface& surface, const WallOptions& options) {
  const auto count = static_cast<Index>(surface.vertices.size());
  if (surface.triangles.empty()) throw Error("make_wall: expected a surface with a triangle, got none");
  for (std::size_t row = 0; row < surface.triangles.size(); ++row) {
    for (const Index i : surface.triangles[row]) {
      if (i >= 0 && i < count) continue;
      throw Error("make_wall: triangle " + std::to_string(row) + ": expected rows of vertices from 0 to " +
                  std::to_string(count - 1) + ", got " + std::to_string(i));
    }
  }
  for (Index i = 0; i < count; ++i) {
    if (surface.vertices[i].allFinite()) continue;
    throw Error("make_wall: expected finite coordinates, but those of vertex " + std::to_string(i) + " are not");
  }
  if (!(options.spacing > 0.0)) {
    throw Error("make_wall: expected a spacing above 0 m (infinite: the surface's own triangles), got " +
                to_decimal(options.spacing));
  }
  if (!(options.material.thickness > 0.0)) {
    throw Error("make_wall: expected a material with a thickness above 0 m, got " +
                to_decimal(options.material.thickness));
  }
}

/// Without vertices that no triangle has.
Model model_of(const Surface& surface) {
  Model model;
  std::vector<Index> row_of(surface.vertices.size(), -1);
  for (const auto& triangle : surface.triangles) {
    Cell cell{.type = CellType::triangle};
    for (const Index vertex : triangle) {
      if (row_of[vertex] == -1) {
        row_of[vertex] = model.particle_count();
        model.rest.push_back(surface.vertices[vertex]);
      }
      cell.particles.push_back(row_of[vertex]);
    }
    model.cells.push_back(std::move(cell));
  }
  model.mass.assign(model.rest.size(), 1.0);
  model.stiffness.assign(model.rest.size(), 1.0);
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  return model;
}

}  // namespace

Model make_wall(const Surface& surface, const WallOptions& options) {
  require_valid(surface, options);
  constexpr std::size_t most_triangles = 20'000'000;
  Surface fine = surface;
  while (longest_of(fine) > longest_side * options.spacing) {
    if (4 * fine.triangles.size() > most_triangles) {
      throw Error("make_wall: a spacing of " + to_decimal(options.spacing) +
                  " m takes more than 20 million triangles; is it in the wrong unit?");
    }
    fine = divided(fine);
  }
  Model model = model_of(fine);
  set_material(model, options.material);
  model.notes.insert(model.notes.begin(), surface.notes.begin(), surface.notes.end());
  return model;
}

int add_capsule(Model& model, const Material& material, const Contains& contains) {
  validate(model);
  if (!(material.thickness > 0.0)) {
    throw Error("add_capsule: expected a material with a thickness above 0 m, got " + to_decimal(material.thickness));
  }
  if (has_cuts(model)) {
    throw Error(ErrorCode::not_supported, "add_capsule: expected a body without cuts; add the capsule, then cut");
  }
  Model with = model;
  std::vector<Index> rows;  // of the new triangles
  std::map<std::array<Index, 3>, std::size_t> walls;
  const auto key = [](std::vector<Index> particles) {
    std::ranges::sort(particles);
    return std::array<Index, 3>{particles[0], particles[1], particles[2]};
  };
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    if (is_wall(model, model.cells[row])) walls[key(model.cells[row].particles)] = row;
  }
  for (Facet& facet : facets_of_cells(model, std::vector<char>(model.rest.size(), 1), OuterFaces(model))) {
    std::vector<Index>& ring = facet.particles;
    Vec3 centre = Vec3::Zero();
    for (const Index i : ring) centre += model.rest[i] / static_cast<double>(ring.size());
    if (contains && !contains(centre)) continue;
    if (ring_area(ring, model.rest).dot(facet.area) < 0.0) std::ranges::reverse(ring);
    for (std::size_t k = 2; k < ring.size(); ++k) {
      Cell cell{.type = CellType::triangle, .particles = {ring[0], ring[k - 1], ring[k]}};
      if (const auto known = walls.find(key(cell.particles)); known != walls.end()) {
        throw Error("add_capsule: " + cell_label(model, known->second) + " is a wall on that surface already");
      }
      rows.push_back(static_cast<Index>(with.cells.size()));
      with.cells.push_back(std::move(cell));
    }
  }
  if (rows.empty()) throw Error("add_capsule: expected outer faces of volume cells in the region, but there are none");
  with.add_group(capsule_group, {});
  with.components.back().cell_refs = rows;
  set_material(with, material, capsule_group);
  with.components.resize(model.components.size());  // without the group's root
  model = std::move(with);
  return static_cast<int>(rows.size());
}

int clamp_edges(Model& model, const Contains& contains) {
  validate(model);
  struct Edge {
    int triangles = 0;
    bool stays = false;  // as it is: clamped, or of a triangle that a cut crosses
    Index material = -1;
  };
  std::map<std::array<Index, 2>, Edge> edges;
  for (const Cell& cell : model.cells) {
    const bool clamps = cell.type == CellType::line && cell.material >= 0;
    if (!clamps && !is_wall(model, cell)) continue;
    for (const CellEdge& edge : cell_edges(cell.type)) {
      Edge& own = edges[sorted_edge(cell.particles[edge[0]], cell.particles[edge[1]])];
      own.triangles += !clamps;
      own.stays = own.stays || clamps || !cell.cuts.empty();
      own.material = cell.material;
    }
  }
  int clamped = 0;
  for (const auto& [edge, of] : edges) {
    if (of.triangles != 1 || of.stays) continue;
    if (contains && !contains(0.5 * (model.rest[edge[0]] + model.rest[edge[1]]))) continue;
    model.cells.push_back({.type = CellType::line, .particles = {edge[0], edge[1]}, .material = of.material});
    ++clamped;
  }
  if (clamped == 0) {
    throw Error("clamp_edges: expected edges with one triangle of a wall in the region, but there are none");
  }
  return clamped;
}

}  // namespace phymul
