// SPDX-License-Identifier: MIT
//
// The constants of Law::walls. Of each triangle with the vertices across its sides (a patch of up to six, as the basic
// shell triangle has: Flores and Onate, CMAME 194 (2005) 907), unfolded into its plane:
//   - the gradient at the middle of a side is the one that both diagonals of its two triangles have: the side, and the
//     line between the vertices across it. Both triangles take the same, so that a constant moment is in equilibrium;
//   - the gradient of the triangle is the mean over its sides, second derivatives are the integral of the sides'
//     gradients times their normals over the area;
//   - these second derivatives are right for a quadratic position only where the diagonals halve each other: elsewhere
//     they are L times it. With moduli D the moment is to be D k, so they take the symmetric part of D L^-1.
// At a free edge the derivative across it is the one for which no moment acts there.
#pragma once

#include <phymul/topology_textures.h>

#include <span>
#include <vector>

namespace phymul {

/// Triangle by triangle. Throws Error where the wall has a cell of zero area, two triangles in one place, or a clamped
/// edge that is not one of its own with one triangle.
std::vector<WallTexel> wall_terms(const Model& model);

/// Whether it clamps an edge of a wall (clamp_edges).
inline bool is_clamp(const Cell& cell) {
  return cell.type == CellType::line && cell.material >= 0;
}

/// Of one triangle of a wall: one term, or where it has an edge with more than one other triangle (walls that branch)
/// one for each of these, with shares of its energy in proportion to their bending stiffness, so that a thin wall takes
/// nothing of a thick one that it joins. A part of a triangle that a cut divides has its share of the energy, and what
/// is across a side is the triangle, or the part of one, with which it has the most tissue of the side in common.
/// `cells_of`: [N] rows of all triangles of walls and clamped edges at a particle, others and removed ones too. Throws
/// as above.
std::vector<WallTexel> wall_terms_of(const Model& model, Index row, std::span<const std::vector<Index>> cells_of);

}  // namespace phymul
