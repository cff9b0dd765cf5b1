// SPDX-License-Identifier: MIT
//
// Cells cut into the tetrahedra (2-D: triangles) at their corners, for volume terms.
#pragma once

#include <phymul/model.h>

#include <array>
#include <vector>

namespace phymul {

/// A corner and its edge neighbours: positive volume as listed. In 2-D the last vertex is -1.
struct CornerSimplex {
  std::array<Index, 4> vertex{-1, -1, -1, -1};
  double volume = 0.0;  ///< rest volume of this very simplex, m^3 (2-D: m^2)
  double share = 0.0;   ///< rest volume it stands for; the shares of a cell sum to the cell's volume
  Index cell = -1;      ///< row of Model::cells
};

/// Simplices of one cell. Hexahedra and wedges have one per corner, pyramids one per corner of the ring, quads
/// one per corner; tetrahedra and triangles are their own. A corner whose edges lie in a plane is left out. Throws
/// Error when the cell, or one of its corners, is inside out at rest.
std::vector<CornerSimplex> corner_simplices(const Model& model, Index cell);

/// Those of all cells, in order of cells.
std::vector<CornerSimplex> corner_simplices(const Model& model);

}  // namespace phymul
