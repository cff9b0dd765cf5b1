// SPDX-License-Identifier: MIT
//
// What cuts leave of a tetrahedron or a triangle of a wall (Cell::cuts), and of their sides. A cut is a linear
// function, by its values at corners.
#pragma once

#include <phymul/model.h>

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace phymul {

using FaceCut = std::array<double, 3>;

/// Of a share of a cell: less than this, or more than all but this, is none and all.
inline constexpr double no_share = 1e-9;
inline constexpr std::size_t most_cuts_of_cell = 3;  ///< through a cell

/// Whether it divides the cell, and does not only lie on one of its sides.
bool divides(const CellCut& cut);

/// Share of the volume of a tetrahedron (4 corners), or of the area of a triangle (3), in which all of them are above
/// 0.
double tissue_share(std::span<const CellCut> cuts, std::size_t corners);

/// Share of the area of a face in which all of them are above 0; what lie along the face does not count.
double face_share(std::span<const FaceCut> cuts);
/// Whether that is more than rounding leaves.
bool has_tissue(std::span<const FaceCut> cuts);

/// The share of a side that has tissue of both of two cells, which have its two particles and lie beside each other;
/// 0: both are cut along it.
double tissue_in_common(const Cell& a, const Cell& b, const std::array<Index, 2>& side);
double tissue_in_common(std::span<const Index> of_a, std::span<const CellCut> cuts_of_a, std::span<const Index> of_b,
                        std::span<const CellCut> cuts_of_b, const std::array<Index, 2>& side);

/// Barycentric coordinates of the middle of its section, of a triangle the first three, where a cut of this many
/// corners crosses the cell or lies on a side of it.
std::optional<Eigen::Vector4d> middle_of_section(const CellCut& cut, std::size_t corners);

/// Adds what the cuts of a cell of these particles are on a face of it. Precondition: the face's particles are the
/// cell's.
void add_cuts_of_face(std::span<const Index> particles, std::span<const CellCut> of_cell,
                      const std::array<Index, 3>& face, std::vector<FaceCut>& cuts);

}  // namespace phymul
