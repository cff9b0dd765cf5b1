// SPDX-License-Identifier: MIT
#include "vtk_cells.h"

#include <phymul/error.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "model/cell_geometry.h"

namespace phymul {
namespace {

enum VtkType : std::int64_t { empty = 0, strip = 6, polygon = 7, pixel = 8, voxel = 11, higher_polygon = 36 };

struct TypeRow {
  std::int64_t vtk;
  CellType type;
  std::ptrdiff_t points;  // of the whole cell, the corners first; 0: any number
};

/// Of several numbers of one type the first is written. From 21 on: cells of higher order.
constexpr TypeRow type_rows[] = {
    {1, CellType::atom, 1},           {2, CellType::poly_vertex, 0},  {3, CellType::line, 2},
    {4, CellType::poly_line, 0},      {5, CellType::triangle, 3},     {9, CellType::quad, 4},
    {pixel, CellType::quad, 4},       {10, CellType::tetrahedron, 4}, {12, CellType::hexahedron, 8},
    {voxel, CellType::hexahedron, 8}, {13, CellType::wedge, 6},       {14, CellType::pyramid, 5},
    {21, CellType::line, 3},          {22, CellType::triangle, 6},    {23, CellType::quad, 8},
    {24, CellType::tetrahedron, 10},  {25, CellType::hexahedron, 20}, {26, CellType::wedge, 15},
    {27, CellType::pyramid, 13},      {28, CellType::quad, 9},        {29, CellType::hexahedron, 27},
    {30, CellType::quad, 6},          {31, CellType::wedge, 12},      {32, CellType::wedge, 18},
    {33, CellType::hexahedron, 24},   {34, CellType::triangle, 7},    {35, CellType::line, 4},
    {37, CellType::pyramid, 19},
};

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
    std::int64_t type = vtk.types[c];
    const auto begin = vtk.connectivity.begin() + static_cast<std::ptrdiff_t>(vtk.offset[c]);
    const std::ptrdiff_t points = vtk.offset[c + 1] - vtk.offset[c];
    if (type == empty && points == 0) continue;
    if (type == polygon && (points == 3 || points == 4)) type = points == 3 ? 5 : 9;
    if (type == strip || type == polygon || type == higher_polygon) {
      ++parts.left_out[type == strip ? "triangle strip" : "polygon"];
      continue;
    }
    const auto* const row = std::ranges::find(type_rows, type, &TypeRow::vtk);
    const auto refuse = [&](const std::string& what) {
      throw Error(where + ": cell " + std::to_string(c) + ": expected " + what);
    };
    if (row == std::end(type_rows)) {
      refuse("VTK types 1 to 14 or 21 to 37, of first or second order, got type " + std::to_string(type) +
             "; export tetrahedra, hexahedra, wedges or pyramids");
    }
    if (row->points != 0 ? points != row->points : points == 0) {
      refuse((row->points != 0 ? std::to_string(row->points) + " points" : "points") + " for VTK type " +
             std::to_string(type) + ", got " + std::to_string(points) + "; the file is damaged: export it again");
    }
    const int corners = cell_size(row->type);
    parts.higher_order += corners != 0 && points > corners;
    Cell cell;
    cell.type = row->type;
    for (auto p = begin; p != begin + (corners != 0 ? corners : points); ++p) {
      cell.particles.push_back(first_point + static_cast<Index>(*p));
    }
    if (type == pixel || type == voxel) std::swap(cell.particles[2], cell.particles[3]);
    if (type == voxel) std::swap(cell.particles[6], cell.particles[7]);
    if (cell.type == CellType::wedge && first_triangle_looks_out(parts.points, cell.particles)) {
      turn_wedge(cell.particles);
    }
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
