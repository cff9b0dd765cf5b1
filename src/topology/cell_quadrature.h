// SPDX-License-Identifier: MIT
//
// Shape functions of the solid cells at the points of a quadrature rule.
#pragma once

#include <phymul/model.h>

#include <array>
#include <span>
#include <vector>

namespace phymul {

/// One point of a cell at rest: N_v and grad N_v of its vertices v, and the part of its volume that the point stands
/// for. In 2-D the volume is that of a slice one metre thick, and gradients have no z. Places beyond the cell's
/// vertices have no meaning.
struct CellPoint {
  double volume = 0.0;            ///< m^3
  std::array<double, 8> value{};  ///< N_v, sum 1
  std::array<Vec3, 8> gradient;   ///< 1/m, sum 0
};

/// The points of a solid cell. Exact for products N_i grad N_j on every cell with flat faces or parallel edges: linear
/// functions on triangles and tetrahedra (their centroid), bilinear and trilinear ones on the others (Gauss points);
/// wedges and pyramids are hexahedra with vertices that coincide. Vertices are those of Cell::particles, in that order;
/// a triangle or quad may have either winding. Throws Error, with the cell's name, where the map from the reference
/// cell is folded.
void cell_points(const Model& model, Index row, std::vector<CellPoint>& points);

/// Integral of f^2, f = sum_v N_v at_vertex[v]: of degree 2, which the centroid of a triangle or tetrahedron misses.
double integral_of_square(CellType type, std::span<const CellPoint> points, std::span<const double> at_vertex);

}  // namespace phymul
