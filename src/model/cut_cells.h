// SPDX-License-Identifier: MIT
//
// What cuts leave of a tetrahedron (Cell::cuts) and of its faces. A cut is a linear function, by its values at corners.
#pragma once

#include <phymul/model.h>

#include <array>
#include <span>
#include <vector>

namespace phymul {

using FaceCut = std::array<double, 3>;

/// Share of the tetrahedron's volume in which all of them are above 0.
double tissue_share(std::span<const CellCut> cuts);

/// Whether there is a part of a triangle, of more area than rounding leaves, in which all of them are above 0.
bool has_tissue(std::span<const FaceCut> cuts);

/// Adds what the cuts of a cell of these particles are on a face of it. Precondition: the face's particles are the
/// cell's.
void add_cuts_of_face(std::span<const Index> particles, std::span<const CellCut> of_cell,
                      const std::array<Index, 3>& face, std::vector<FaceCut>& cuts);

}  // namespace phymul
