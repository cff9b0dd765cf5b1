// SPDX-License-Identifier: MIT
//
// The surface of a body: the facets that pressure acts on.
#pragma once

#include <phymul/model.h>

#include <array>
#include <span>
#include <vector>

#include "outer_faces.h"

namespace phymul {

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
