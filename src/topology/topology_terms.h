// SPDX-License-Identifier: MIT
//
// The terms of the energy beside the bases: springs, volumes, cells.
#pragma once

#include <phymul/model.h>
#include <phymul/topology_textures.h>

#include <array>
#include <vector>

namespace phymul {

/// Of a cell cut into the tetrahedra (2-D: triangles) at its corners, for volume terms: a corner and its edge
/// neighbours, positive volume as listed. In 2-D the last vertex is -1.
struct CornerSimplex {
  std::array<Index, 4> vertex{-1, -1, -1, -1};
  double volume = 0.0;  ///< rest volume of this very simplex, m^3 (2-D: m^2)
  double share = 0.0;   ///< rest volume it stands for; the shares of a cell sum to the cell's volume
};

/// Simplices of one cell. Hexahedra and wedges have one per corner, pyramids one per corner of the ring, quads
/// one per corner; tetrahedra and triangles are their own. A corner whose edges lie in a plane is left out. Throws
/// Error when the cell, or one of its corners, is inside out at rest.
std::vector<CornerSimplex> corner_simplices(const Model& model, Index cell);

/// Those of all cells, in order of cells.
std::vector<CornerSimplex> corner_simplices(const Model& model);

/// Each neighbouring pair once, with the mean of the two stiffnesses; ordered by particle numbers.
std::vector<SpringTexel> neighbour_springs(const Model& model);

/// Springs from each of `particles` to each of its neighbours, with the particle's own stiffness.
std::vector<SpringTexel> springs_around(const Model& model, const std::vector<Index>& particles);

/// One row per corner simplex; stiffness kappa * share. Throws Error when no cell fills space.
std::vector<VolumeTexel> volume_terms(const Model& model, double kappa);

}  // namespace phymul
