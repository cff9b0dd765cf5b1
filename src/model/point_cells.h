// SPDX-License-Identifier: MIT
//
// The share of space of each particle of a body that has no cells: of its Voronoi cell the part within the convex hull
// of its neighbours (point_neighbours) and itself. On the surface that hull ends at the particle; so a lattice with
// particles on its sides has half a cell there, a quarter on its edges.
#pragma once

#include <phymul/model.h>

#include <vector>

namespace phymul {

/// Moments about the particle. In 2-D of a layer one metre thick, without its thickness.
struct PointCell {
  double volume = 0.0;         ///< m^3
  Vec3 first = Vec3::Zero();   ///< integral of r, m^4
  Mat3 second = Mat3::Zero();  ///< integral of r r^T, m^5
};

/// The model's neighbours, and where they are few (less than 14, in 2-D 8) the neighbours' neighbours too; in
/// increasing order. The six of a lattice span an octahedron, which is less than the lattice's cell.
RaggedList point_neighbours(const Model& model);

/// By quadrature over directions: the volume of a cube is 0.1 % off. Of order neighbours^3 for each particle.
std::vector<PointCell> point_cells(const Model& model, const RaggedList& neighbours);

/// True for a model with particles only: no cells that fill space.
bool is_body_of_points(const Model& model);

}  // namespace phymul
