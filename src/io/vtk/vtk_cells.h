// SPDX-License-Identifier: MIT
//
// VTK's cell numbers and vertex orders against ours: shared by the readers and the writer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/mesh/mesh_parts.h"

namespace phymul {

/// The cells of a VTK unstructured grid: cell c has the points connectivity[offset[c]] ... connectivity[offset[c+1] -
/// 1].
struct VtkCells {
  std::vector<std::int64_t> offset;        ///< [cells + 1], starts with 0, never decreasing
  std::vector<std::int64_t> connectivity;  ///< [offset.back()], each in [0, points)
  std::vector<std::int64_t> types;         ///< [cells] VTK's number of the cell type
};

/// Appends the cells, the points counted from `first_point`; of cells of second order the corners. Larger polygons and
/// strips are counted in MeshParts::left_out. `where` begins the messages. Throws Error for other types.
void append_vtk_cells(const VtkCells& vtk, Index first_point, const std::string& where, MeshParts& parts);

/// VTK's number of our type.
std::uint8_t vtk_type(CellType type);

/// The cell's particles in VTK's order: that of Model but for wedges, whose first triangle VTK turns outward.
std::vector<Index> vtk_order(const Cell& cell);

}  // namespace phymul
