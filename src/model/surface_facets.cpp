// SPDX-License-Identifier: MIT
#include "surface_facets.h"

#include <algorithm>

#include "cell_geometry.h"
#include "cut_cells.h"
#include "outer_faces.h"

namespace phymul {
namespace {

bool all_chosen(const std::array<Index, 4>& ring, std::span<const char> chosen) {
  return std::all_of(ring.begin(), ring.end(), [&](Index i) { return i < 0 || chosen[i]; });
}

Facet made_facet(const Model& model, const std::array<Index, 4>& ring, bool inside_out) {
  Facet facet;
  std::copy_if(ring.begin(), ring.end(), std::back_inserter(facet.particles), [](Index i) { return i >= 0; });
  if (facet.particles.size() == 2) {
    // A counter-clockwise boundary has the outside on its right.
    const Vec3 along = model.rest[ring[1]] - model.rest[ring[0]];
    facet.area = Vec3(along.y(), -along.x(), 0.0);
  } else {
    facet.area = area_vector(facet.particles, model.rest);
  }
  if (inside_out) facet.area = -facet.area;
  return facet;
}

}  // namespace

std::vector<Facet> surface_facets(const Model& model, std::span<const char> chosen) {
  const bool made_of_cells =
      std::ranges::any_of(model.cells, [&](const Cell& cell) { return is_solid(model.dimension, cell.type); });
  return made_of_cells ? facets_of_cells(model, chosen) : explicit_facets(model, chosen);
}

std::vector<Facet> explicit_facets(const Model& model, std::span<const char> chosen) {
  std::vector<Facet> facets;
  for (const Cell& cell : model.cells) {
    const bool facet_type = model.dimension == 2 ? cell.type == CellType::line
                                                 : cell.type == CellType::triangle || cell.type == CellType::quad;
    if (!facet_type || cell.share == 0.0) continue;
    std::array<Index, 4> ring{-1, -1, -1, -1};
    std::copy(cell.particles.begin(), cell.particles.end(), ring.begin());
    if (all_chosen(ring, chosen)) facets.push_back(made_facet(model, ring, false));
  }
  return facets;
}

std::vector<Facet> facets_of_cells(const Model& model, std::span<const char> chosen) {
  std::vector<Facet> facets;
  std::vector<FaceCut> cuts;
  const auto is_beyond_cut = [&](const OuterFace& face) {
    if (face.cell->cuts.empty()) return false;
    cuts.clear();
    add_cuts_of_face(face.cell->particles, face.cell->cuts, {face.ring[0], face.ring[1], face.ring[2]}, cuts);
    return !has_tissue(cuts);
  };
  // Both cells at an inner face have it chosen, so leaving out the others first does not bare inner faces.
  each_outer_face(
      model, [&](Index i) { return chosen[i] != 0; },
      [&](std::span<const OuterFace> faces) {
        if (std::ranges::all_of(faces, is_beyond_cut)) return;
        const bool inside_out = signed_measure(model.dimension, *faces[0].cell, model.rest) < 0.0;
        facets.push_back(made_facet(model, faces[0].ring, inside_out));
      });
  return facets;
}

}  // namespace phymul
