// SPDX-License-Identifier: MIT
#include "body_surface.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

namespace {

using phymul::CellType;
using phymul::Index;

using Corners = std::vector<int>;

/// Faces of a volume cell, outward, as places in Cell::particles.
std::span<const Corners> faces_of(CellType type) {
  static const std::vector<Corners> tetrahedron{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  static const std::vector<Corners> hexahedron{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                               {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  static const std::vector<Corners> wedge{{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  static const std::vector<Corners> pyramid{{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  switch (type) {
    case CellType::tetrahedron:
      return tetrahedron;
    case CellType::hexahedron:
      return hexahedron;
    case CellType::wedge:
      return wedge;
    case CellType::pyramid:
      return pyramid;
    default:
      return {};
  }
}

std::vector<Face> outer_faces(const phymul::Model& model) {
  std::map<std::vector<Index>, std::pair<Face, int>> seen;  // by sorted corners: the face and how many cells have it
  for (const phymul::Cell& cell : model.cells) {
    if (cell.share == 0.0) continue;
    for (const Corners& corners : faces_of(cell.type)) {
      Face face;
      for (const int corner : corners) face.corners.push_back(cell.particles[static_cast<std::size_t>(corner)]);
      bool beyond_cut = false;  // no tissue of the cell is there
      for (const phymul::CellCut& cut : cell.cuts) {
        beyond_cut = beyond_cut || std::ranges::all_of(corners, [&](int corner) { return cut[corner] <= 0.0; });
      }
      std::vector<Index> key = face.corners;
      std::sort(key.begin(), key.end());
      auto& [first, count] = seen[key];
      if (count == 0) first = std::move(face);
      count += beyond_cut ? 2 : 1;
    }
  }
  std::vector<Face> faces;
  for (auto& [key, entry] : seen) {
    if (entry.second == 1) faces.push_back(std::move(entry.first));
  }
  return faces;
}

std::vector<SurfaceEdge> edges_of(const std::vector<Face>& faces) {
  std::map<std::pair<Index, Index>, SurfaceEdge> seen;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::vector<Index>& corners = faces[f].corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % corners.size()]);
      SurfaceEdge& edge = seen[{a, b}];
      edge.ends = {a, b};
      edge.faces[edge.faces[0] < 0 ? 0 : 1] = static_cast<int>(f);
    }
  }
  std::vector<SurfaceEdge> edges;
  for (const auto& [ends, edge] : seen) edges.push_back(edge);
  return edges;
}

std::vector<SurfaceEdge> links_of(const phymul::Model& model) {
  std::vector<SurfaceEdge> edges;
  for (Index i = 0; i < model.particle_count(); ++i) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) {
      if (i < *j) edges.push_back({{i, *j}, {-1, -1}});
    }
  }
  return edges;
}

}  // namespace

BodySurface surface_of(const phymul::Model& model) {
  BodySurface surface;
  surface.faces = outer_faces(model);
  if (surface.faces.empty()) {
    for (const phymul::Cell& cell : model.cells) {
      if (cell.type == CellType::triangle || cell.type == CellType::quad) surface.faces.push_back({cell.particles});
    }
  }
  surface.edges = surface.faces.empty() ? links_of(model) : edges_of(surface.faces);
  return surface;
}

phymul::Model triangle_body(phymul::VecList vertices, const std::vector<std::array<Index, 3>>& triangles) {
  phymul::Model model;
  model.rest = std::move(vertices);
  for (const auto& corners : triangles) {
    phymul::Cell& cell = model.cells.emplace_back();
    cell.type = CellType::triangle;
    cell.particles.assign(corners.begin(), corners.end());
  }
  return model;
}
