// SPDX-License-Identifier: MIT
//
// The faces of volume cells (in 2-D: edges of triangles and quads) that no other cell has. The surface of a body: the
// facets that pressure acts on.
#pragma once

#include <phymul/model.h>
#include <phymul/surface.h>

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "cell_geometry.h"

namespace phymul {

struct OuterFace {
  const Cell* cell = nullptr;
  std::array<Index, 4> ring{};  ///< in order, outward in a rightly wound cell; -1 at the end where there are fewer
  bool is_cut = false;          ///< cuts cross the cell
};

/// The particles of a face, sorted, those that there are not first: compared as numbers.
struct FaceKey {
  std::uint64_t high = 0, low = 0;

  explicit FaceKey(std::array<Index, 4> of) {
    const auto order = [&](std::size_t a, std::size_t b) {
      if (of[b] < of[a]) std::swap(of[a], of[b]);
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
    const auto pair = [&](std::size_t k) {
      return std::uint64_t{static_cast<std::uint32_t>(of[k] + 1)} << 32 | static_cast<std::uint32_t>(of[k + 1] + 1);
    };
    high = pair(0);
    low = pair(2);
  }
  auto operator<=>(const FaceKey&) const = default;
};

/// Found once for a body, and followed while its cells change.
class OuterFaces {
 public:
  OuterFaces() = default;
  explicit OuterFaces(const Model& model) { follow(model); }

  /// Looks at all cells, and does more for those alone that are others than at the last call.
  void follow(const Model& model);
  /// Looks at these rows, where no other has changed since the last call; those beyond the model's cells are gone.
  void follow(const Model& model, std::span<const Index> cells);

  /// Of a row of the model that was followed: none where it is no solid cell.
  std::span<const Index> particles_of(Index cell) const {
    if (cell >= static_cast<Index>(known_.size())) return {};
    const Corners& own = known_[cell];
    return std::span(own).first(static_cast<std::size_t>(std::ranges::find(own, -1) - own.begin()));
  }

  /// Rows of the solid cells that cuts cross, ascending.
  const std::vector<Index>& cut_cells() const { return cut_cells_; }

  /// Calls visit(std::span<const OuterFace>) for each face of the model that was followed, in order of their sorted
  /// particles, those of fewer particles first. Where a cut ends inside the body both parts of a cell have the same
  /// face, and the span has both, in order of cells.
  template <class Visit>
  void each(const Model& model, Visit visit) const {
    std::vector<OuterFace> found;
    std::vector<Index> places;
    for (const Outer& own : outer_) {
      found.clear();
      found.push_back({&model.cells[own.cell], own.ring, own.is_cut});
      if (own.several) {
        found.clear();
        places_of(own.face, places);
        for (const Index place : places) {
          const Cell& cell = model.cells[place / most_faces];
          found.push_back({&cell, ring_at(model, place), !cell.cuts.empty()});
        }
      }
      visit(std::span<const OuterFace>(found));
    }
  }

  /// Calls visit(particle) for one particle of each outer face.
  template <class Visit>
  void each_place(Visit visit) const {
    for (const Outer& own : outer_) visit(own.ring[0]);
  }

 private:
  static constexpr Index most_faces = 6;  // of a cell
  using Corners = std::array<Index, 8>;   // of a cell, -1 at the end where there are fewer
  static constexpr Corners none() { return {-1, -1, -1, -1, -1, -1, -1, -1}; }
  struct Face {
    FaceKey key;
    Index first = -1;  // place, and next_ of it, and so on
    bool changed = false, outer = false;
  };
  struct Outer {
    FaceKey key;
    std::array<Index, 4> ring{};
    Index face = -1, cell = -1;  // rows of faces_ and cells, the first of those that have it
    bool is_cut = false, several = false, stale = false;
  };

  Index row_of(const FaceKey& key);
  void grow();
  void take_out(Index cell);
  void put_in(int dimension, const Cell& cell, Index row);
  void mark(Index face);
  void places_of(Index face, std::vector<Index>& places) const;  // ascending
  bool is_outer(const Model& model, const std::vector<Index>& places) const;
  static std::array<Index, 4> ring_at(const Model& model, Index place) {
    return face_particles(model.dimension, model.cells[place / most_faces],
                          static_cast<std::size_t>(place % most_faces));
  }

  std::vector<Corners> known_;  // [cells]; none: it is not there
  // Place: of a face of a cell, most_faces times the cell's row and the face's number in it.
  std::vector<Index> next_, face_of_;  // [places] of the same face; rows of faces_; -1: none
  std::vector<Face> faces_;            // also those that no cell has any more
  std::vector<Index> table_;           // rows of faces_, by their hashes; -1: free
  std::vector<Index> changed_;         // rows of faces_
  std::vector<Outer> outer_;           // by their keys
  std::vector<Index> cut_cells_;
};

/// tissue_surface() of a valid model in 3-D, or of some of its cells, and its outer faces: nothing is checked.
TissueSurface tissue_surface_of(const Model& model, const OuterFaces& outer);

/// Whether a cut crosses a cell that is there.
bool has_cuts(const Model& model);

struct Facet {
  std::vector<Index> particles;  ///< 2 (an edge, in 2-D), 3 or 4
  Vec3 area;                     ///< outward normal times rest area that cuts leave, m^2 (2-D: times length, m)
};

/// Facets of the rest shape's surface all of whose particles are chosen, outward. They are the faces that exactly one
/// volume cell has, and the walls beside them, as they are wound; in a model without volume cells its triangles and
/// quads. In 2-D: the edges of exactly one triangle or quad, else the lines.
std::vector<Facet> surface_facets(const Model& model, std::span<const char> chosen);
/// Of them those of volume cells (2-D: of triangles and quads), `outer` of the model, those of walls_beside_cells(),
/// and in a model without volume cells those that are cells themselves.
std::vector<Facet> facets_of_cells(const Model& model, std::span<const char> chosen, const OuterFaces& outer);
std::vector<Facet> facets_of_walls(const Model& model, std::span<const char> chosen, std::span<const Index> walls);
std::vector<Facet> explicit_facets(const Model& model, std::span<const char> chosen);
/// Rows of the triangles of walls that are on no outer face, as a capsule is; ascending.
std::vector<Index> walls_beside_cells(const Model& model, const OuterFaces& outer);

/// What bounds volume cells, or in a model without them all facets, as triangles: counter-clockwise seen from outside
/// whatever the winding of their cells, of a ring of four particles two.
std::vector<std::array<Index, 3>> outward_triangles(const Model& model);

/// Of a ring of three or four particles: its area vector, and its triangles.
Vec3 ring_area(std::span<const Index> ring, std::span<const Vec3> position);

}  // namespace phymul
