// SPDX-License-Identifier: MIT
#include "corner_simplices.h"

#include "model/cell_geometry.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace phymul {
namespace {

// Corner first, then its edge neighbours; counter-clockwise.
constexpr CellCorner triangle_corners[] = {{0, 1, 2, -1}};
constexpr CellCorner quad_corners[] = {{0, 1, 3, -1}, {1, 2, 0, -1}, {2, 3, 1, -1}, {3, 0, 2, -1}};

// Volume (area) over the longest edge cubed (squared) below which a corner is flat.
constexpr double flat_corner = 1e-6;

std::span<const CellCorner> corners_of(CellType type) {
  if (type == CellType::triangle) return triangle_corners;
  if (type == CellType::quad) return quad_corners;
  const std::span<const CellCorner> corners = cell_corners(type);
  return type == CellType::tetrahedron ? corners.first(1) : corners;  // its four corners are all the tetrahedron itself
}

struct Extent {
  double volume;        // signed
  double longest_edge;  // from the corner
};

Extent extent(const VecList& rest, const std::array<Index, 4>& v) {
  const Vec3 a = rest[v[1]] - rest[v[0]];
  const Vec3 b = rest[v[2]] - rest[v[0]];
  if (v[3] < 0) return {a.cross(b).z() / 2, std::max(a.norm(), b.norm())};
  const Vec3 c = rest[v[3]] - rest[v[0]];
  return {a.cross(b).dot(c) / 6, std::max({a.norm(), b.norm(), c.norm()})};
}

// In the plane either winding is as good: triangles seen from behind are turned over.
bool wound_clockwise(const Model& model, const Cell& cell) {
  return model.dimension == 2 && signed_measure(2, cell, model.rest) < 0.0;
}

[[noreturn]] void fail_inside_out(const Model& model, Index cell) {
  throw Error(
      ErrorCode::invalid_model,
      cell_label(model, cell) +
          " is inside out at rest, as a whole or at one of its corners: its volume is not positive. Run check_mesh, "
          "which turns wrongly wound cells, or mend the mesh");
}

}  // namespace

std::vector<CornerSimplex> corner_simplices(const Model& model, Index cell_row) {
  const Cell& cell = model.cells[cell_row];
  const bool clockwise = wound_clockwise(model, cell);
  std::vector<CornerSimplex> result;
  double sum = 0.0;
  for (const CellCorner& ends : corners_of(cell.type)) {
    CornerSimplex simplex;
    simplex.cell = cell_row;
    for (std::size_t v = 0; v < 4; ++v) simplex.vertex[v] = ends[v] < 0 ? -1 : cell.particles[ends[v]];
    if (clockwise) std::swap(simplex.vertex[1], simplex.vertex[2]);
    const Extent size = extent(model.rest, simplex.vertex);
    const double flat = flat_corner * std::pow(size.longest_edge, model.dimension);
    if (size.volume < -flat) fail_inside_out(model, cell_row);
    if (size.volume <= flat) continue;
    simplex.volume = size.volume;
    sum += size.volume;
    result.push_back(simplex);
  }
  const double measure = signed_measure(model.dimension, cell, model.rest);
  const double whole = clockwise ? -measure : measure;
  if (!(whole > 0.0) || !(sum > 0.0)) fail_inside_out(model, cell_row);
  for (CornerSimplex& simplex : result) simplex.share = simplex.volume * (whole / sum);
  return result;
}

std::vector<CornerSimplex> corner_simplices(const Model& model) {
  std::vector<CornerSimplex> result;
  for (Index cell = 0; cell < static_cast<Index>(model.cells.size()); ++cell) {
    if (!is_solid(model.dimension, model.cells[cell])) continue;
    const std::vector<CornerSimplex> corners = corner_simplices(model, cell);
    result.insert(result.end(), corners.begin(), corners.end());
  }
  return result;
}

}  // namespace phymul
