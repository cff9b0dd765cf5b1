// SPDX-License-Identifier: MIT
#include "vtk_cells.h"

#include <phymul/error.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "model/cell_geometry.h"

namespace phymul {
namespace {

enum VtkType : std::int64_t {
  vtk_empty = 0,
  vtk_vertex = 1,
  vtk_poly_vertex = 2,
  vtk_line = 3,
  vtk_poly_line = 4,
  vtk_triangle = 5,
  vtk_polygon = 7,
  vtk_pixel = 8,
  vtk_quad = 9,
  vtk_tetra = 10,
  vtk_voxel = 11,
  vtk_hexahedron = 12,
  vtk_wedge = 13,
  vtk_pyramid = 14,
  vtk_first_quadratic = 21
};

/// Where a message is about; made into words only when one is needed.
struct Place {
  const std::string& file;
  std::size_t cell;

  std::string words() const { return file + ": cell " + std::to_string(cell) + ": "; }
};

[[noreturn]] void refuse_type(std::int64_t type, const Place& place) {
  std::string message =
      place.words() + "expected first-order cells (VTK types 1 to 5, 8 to 14), got type " + std::to_string(type);
  if (type >= vtk_first_quadratic && type != 41 && type != 42) {
    message += ", of second or higher order; export the mesh with first-order (linear) cells";
  } else {
    message += "; export tetrahedra, hexahedra, wedges or pyramids";
  }
  throw Error(message);
}

struct TypeRow {
  std::int64_t vtk;
  CellType type;
};

/// Of several numbers of one type the first is written.
constexpr TypeRow type_rows[] = {
    {vtk_vertex, CellType::atom},
    {vtk_poly_vertex, CellType::poly_vertex},
    {vtk_line, CellType::line},
    {vtk_poly_line, CellType::poly_line},
    {vtk_triangle, CellType::triangle},
    {vtk_quad, CellType::quad},
    {vtk_pixel, CellType::quad},
    {vtk_tetra, CellType::tetrahedron},
    {vtk_hexahedron, CellType::hexahedron},
    {vtk_voxel, CellType::hexahedron},
    {vtk_wedge, CellType::wedge},
    {vtk_pyramid, CellType::pyramid},
};

CellType our_type(std::int64_t type, std::size_t corners, const Place& place) {
  if (type == vtk_polygon) {
    if (corners == 3) return CellType::triangle;
    if (corners == 4) return CellType::quad;
    throw Error(place.words() + "expected polygons of 3 or 4 corners, got one of " + std::to_string(corners) +
                "; triangulate the mesh and export it again");
  }
  const auto* const row = std::ranges::find(type_rows, type, &TypeRow::vtk);
  if (row == std::end(type_rows)) refuse_type(type, place);
  return row->type;
}

/// VTK's documentation has a wedge's first triangle look outward; many writers have it look inward, as Model has it.
/// The volume tells which it is, as it tells check_mesh().
bool first_triangle_looks_out(const VecList& points, const std::vector<Index>& particles) {
  return signed_volume(CellType::wedge, particles, points) < 0.0;
}

void turn_wedge(std::vector<Index>& p) {
  std::swap(p[1], p[2]);
  std::swap(p[4], p[5]);
}

}  // namespace

void append_vtk_cells(const VtkCells& vtk, Index first_point, const std::string& where, MeshParts& parts) {
  for (std::size_t c = 0; c < vtk.types.size(); ++c) {
    const std::int64_t type = vtk.types[c];
    if (type == vtk_empty) continue;
    const Place place{where, c};
    const auto begin = vtk.connectivity.begin() + static_cast<std::ptrdiff_t>(vtk.offset[c]);
    const auto end = vtk.connectivity.begin() + static_cast<std::ptrdiff_t>(vtk.offset[c + 1]);
    Cell cell;
    cell.type = our_type(type, static_cast<std::size_t>(end - begin), place);
    const int corners = cell_size(cell.type);
    if (corners != 0 ? end - begin != corners : end == begin) {
      throw Error(place.words() + "expected " + (corners != 0 ? std::to_string(corners) + " points" : "points") +
                  " for VTK type " + std::to_string(type) + ", got " + std::to_string(end - begin) +
                  "; the file is damaged: export it again");
    }
    for (auto p = begin; p != end; ++p) cell.particles.push_back(first_point + static_cast<Index>(*p));
    if (type == vtk_pixel || type == vtk_voxel) std::swap(cell.particles[2], cell.particles[3]);
    if (type == vtk_voxel) std::swap(cell.particles[6], cell.particles[7]);
    if (type == vtk_wedge && first_triangle_looks_out(parts.points, cell.particles)) turn_wedge(cell.particles);
    parts.cells.push_back(std::move(cell));
  }
}

std::uint8_t vtk_type(CellType type) {
  return static_cast<std::uint8_t>(std::ranges::find(type_rows, type, &TypeRow::type)->vtk);
}

std::vector<Index> vtk_order(const Cell& cell) {
  std::vector<Index> particles = cell.particles;
  if (cell.type == CellType::wedge) turn_wedge(particles);
  return particles;
}

}  // namespace phymul
