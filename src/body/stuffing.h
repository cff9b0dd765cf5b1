// SPDX-License-Identifier: MIT
//
// Isosurface stuffing: F. Labelle, J. R. Shewchuk, "Isosurface stuffing: fast tetrahedral meshes with good dihedral
// angles", ACM Trans. Graph. 26 (3), 2007, article 57. Points of a body-centred lattice near the surface move onto it,
// and what the surface still crosses of the lattice's tetrahedra is cut.
#pragma once

#include <phymul/types.h>

#include <array>
#include <vector>

#include "interior.h"
#include "lattice.h"

namespace phymul {

using Tetrahedron = std::array<Index, 4>;
class GradedLattice;

struct Stuffing {
  VecList place;                   ///< m, numbered as the cells first use them
  std::vector<char> at_surface;    ///< [places] 1: on the surface
  std::vector<Tetrahedron> cells;  ///< of positive volume, in the lattice's order
  std::vector<double> leaf_edge;   ///< [places] share of the coarsest edge; empty: 1 everywhere
};

/// Fills the shape. All points of the lattice's outermost cubes must lie outside. Empty if no point is inside.
Stuffing stuffed(const Interior& interior, const CentredLattice& lattice);
/// Cells may be thin or inverted where the spacing changes at the surface: see improve_cells().
Stuffing stuffed(const Interior& interior, const GradedLattice& lattice);

}  // namespace phymul
