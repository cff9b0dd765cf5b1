// SPDX-License-Identifier: MIT
//
// The surface of a body: the facets that pressure acts on.
#pragma once

#include <phymul/model.h>

#include <span>
#include <vector>

namespace phymul {

struct Facet {
  std::vector<Index> particles;  ///< 2 (an edge, in 2-D), 3 or 4
  Vec3 area;                     ///< outward normal times rest area, m^2 (2-D: times length, m)
};

/// Facets of the rest shape's surface all of whose particles are chosen, outward. They are the faces that exactly one
/// volume cell has; in a model without volume cells its triangles and quads as they are wound. In 2-D: the edges of
/// exactly one triangle or quad, else the lines.
std::vector<Facet> surface_facets(const Model& model, std::span<const char> chosen);

}  // namespace phymul
