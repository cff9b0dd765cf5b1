// SPDX-License-Identifier: MIT
#include "surface_facets.h"

#include <algorithm>

#include "cell_geometry.h"
#include "cut_cells.h"

namespace phymul {
namespace {

struct Candidate {
  std::array<Index, 4> key;   // sorted particles, -1 in front where there are fewer
  std::array<Index, 4> ring;  // in order, -1 at the end where there are fewer
  bool inside_out;            // the cell it belongs to has negative volume
  bool beyond_cut;            // no tissue of its cell is there
  const Cell* cell;
};

Candidate candidate(const Cell& cell, std::array<Index, 4> ring, bool inside_out) {
  Candidate made{ring, ring, inside_out, false, &cell};
  std::sort(made.key.begin(), made.key.end());
  return made;
}

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

std::vector<Facet> explicit_facets(const Model& model, std::span<const char> chosen) {
  std::vector<Facet> facets;
  for (const Cell& cell : model.cells) {
    const bool facet_type = model.dimension == 2 ? cell.type == CellType::line
                                                 : cell.type == CellType::triangle || cell.type == CellType::quad;
    if (!facet_type) continue;
    std::array<Index, 4> ring{-1, -1, -1, -1};
    std::copy(cell.particles.begin(), cell.particles.end(), ring.begin());
    if (all_chosen(ring, chosen)) facets.push_back(made_facet(model, ring, false));
  }
  return facets;
}

}  // namespace

std::vector<Facet> surface_facets(const Model& model, std::span<const char> chosen) {
  bool made_of_cells = false;
  std::vector<Candidate> faces;
  for (const Cell& cell : model.cells) {
    made_of_cells = made_of_cells || is_solid(model.dimension, cell.type);
    if (!is_solid(model.dimension, cell)) continue;
    const bool inside_out = signed_measure(model.dimension, cell, model.rest) < 0.0;
    // Both cells at an inner face have it chosen, so leaving out the others first does not bare inner faces.
    std::vector<FaceCut> cuts;
    each_face(model.dimension, cell, [&](const std::array<Index, 4>& ring) {
      if (!all_chosen(ring, chosen)) return;
      faces.push_back(candidate(cell, ring, inside_out));
      if (cell.cuts.empty()) return;
      cuts.clear();
      add_cuts_of_face(cell.particles, cell.cuts, {ring[0], ring[1], ring[2]}, cuts);
      faces.back().beyond_cut = !has_tissue(cuts);
    });
  }
  if (!made_of_cells) return explicit_facets(model, chosen);
  std::stable_sort(faces.begin(), faces.end(), [](const Candidate& a, const Candidate& b) { return a.key < b.key; });
  std::vector<Facet> facets;
  for (std::size_t from = 0, to = 0; from < faces.size(); from = to) {
    for (to = from + 1; to < faces.size() && faces[to].key == faces[from].key;) ++to;
    // Where a cut ends inside the body both parts of a cell have the same face.
    const auto of_one_cell = [&](const Candidate& face) {
      return cell_centre(*face.cell, model.rest) == cell_centre(*faces[from].cell, model.rest);
    };
    const auto first = faces.begin() + static_cast<std::ptrdiff_t>(from),
               last = faces.begin() + static_cast<std::ptrdiff_t>(to);
    if (to > from + 1 && (first->cell->cuts.empty() || !std::all_of(first, last, of_one_cell))) continue;
    if (std::all_of(first, last, [](const Candidate& face) { return face.beyond_cut; })) continue;
    facets.push_back(made_facet(model, faces[from].ring, faces[from].inside_out));
  }
  return facets;
}

}  // namespace phymul
