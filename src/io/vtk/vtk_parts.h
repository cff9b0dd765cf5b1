// SPDX-License-Identifier: MIT
//
// VTK's cell numbers and vertex orders against ours: shared by the readers and the writer. The bytes of one data array
// of a VTK XML file: base64 or raw, zlib-compressed or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/byte_source.h"
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

struct VtuCoding {
  bool base64 = false;
  bool compressed = false;                      ///< blocks of zlib
  bool swap = false;                            ///< the file's byte order is not this machine's
  NumberType header_type = NumberType::uint32;  ///< of the byte counts before the data
};

/// Decodes the array that begins at the start of `coded` (which may go on beyond it). It must have `expected_bytes`.
/// `place` begins the messages. Throws Error.
std::string decode_vtu_array(std::string_view coded, const VtuCoding& coding, std::size_t expected_bytes,
                             const std::string& place);

}  // namespace phymul
