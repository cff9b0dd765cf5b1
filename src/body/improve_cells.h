// SPDX-License-Identifier: MIT
#pragma once

#include "stuffing.h"

namespace phymul {

/// Moves particles of cells that have a dihedral angle below 15 or above 165 degrees, or are inverted, to where the
/// worst angle of their cells is better: those inside anywhere, those of the outer faces in the mean plane of these. By
/// search along axes and diagonals with ever shorter steps (L. A. Freitag, C. Ollivier-Gooch, "Tetrahedral mesh
/// improvement using swapping and smoothing", Int. J. Numer. Meth. Eng. 40, 1997, improve the smallest angle likewise,
/// by its gradient).
void improve_cells(Stuffing& body, const std::vector<std::array<Index, 3>>& outer_faces);

}  // namespace phymul
