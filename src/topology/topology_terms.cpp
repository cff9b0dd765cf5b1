// SPDX-License-Identifier: MIT
#include "topology_terms.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "model/cell_geometry.h"

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

SpringTexel spring(const Model& model, Index i, Index j, double stiffness) {
  return {{i, j}, (model.rest[j] - model.rest[i]).norm(), stiffness};
}

}  // namespace

std::vector<CornerSimplex> corner_simplices(const Model& model, Index cell_row) {
  const Cell& cell = model.cells[cell_row];
  const bool clockwise = wound_clockwise(model, cell);
  std::vector<CornerSimplex> result;
  double sum = 0.0;
  for (const CellCorner& ends : corners_of(cell.type)) {
    CornerSimplex simplex;
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

std::vector<SpringTexel> neighbour_springs(const Model& model) {
  std::vector<std::array<Index, 2>> pairs;
  pairs.reserve(model.neighbours.entry.size());
  for (Index i = 0; i < model.particle_count(); ++i) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) {
      pairs.push_back({std::min(i, *j), std::max(i, *j)});
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  std::vector<SpringTexel> springs;
  springs.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    springs.push_back(spring(model, i, j, (model.stiffness[i] + model.stiffness[j]) / 2));
  }
  return springs;
}

std::vector<SpringTexel> springs_around(const Model& model, const std::vector<Index>& particles) {
  std::vector<SpringTexel> springs;
  for (const Index i : particles) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) {
      springs.push_back(spring(model, i, *j, model.stiffness[i]));
    }
  }
  return springs;
}

std::vector<VolumeTexel> volume_terms(const Model& model, double kappa) {
  std::vector<VolumeTexel> terms;
  for (const CornerSimplex& simplex : corner_simplices(model)) {
    terms.push_back({simplex.vertex, 1.0 / simplex.volume, kappa * simplex.share});
  }
  if (terms.empty()) {
    throw Error(model.dimension == 3
                    ? "a volume term needs tetrahedra, wedges, pyramids or hexahedra; the model has none. "
                      "Set volume_stiffness to 0, or add cells"
                    : "a volume term in 2-D needs triangles or quads; the model has none. Set "
                      "volume_stiffness to 0, or add cells");
  }
  return terms;
}

}  // namespace phymul
