// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/surface_patch.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "base/decimal.h"

namespace phymul {
namespace {

/// Of a triangle in one direction.
constexpr double most_cuts = 1000.0;
/// Times as many parts along a triangle as along its shortest side: beyond, equal numbers would take far too many.
constexpr int thin_ratio = 8;

constexpr double most_rows = 1e15;  // of the grid, on either side of the origin

/// Sums by cells of a grid, in the order of the cells.
struct Merged {
  Vec3 moment = Vec3::Zero();  ///< sum of area times place
  double area = 0.0;
};
using Grid = std::map<std::array<std::int64_t, 3>, Merged>;

/// Cuts the triangle into n^2 alike ones, a long thin one into pieces of n strips across it. Those count whose centres
/// are inside.
void add_triangle(std::array<Vec3, 3> corner, double spacing, const Contains& inside, Grid& grid) {
  const auto side = [&](int k) { return (corner[(k + 2) % 3] - corner[(k + 1) % 3]).norm(); };
  const auto parts = [&](double length) {
    return static_cast<int>(std::clamp(std::ceil(length / spacing), 1.0, most_cuts));
  };
  const auto add = [&](const Vec3& place, double area) {
    if (!inside(place)) return;
    std::array<std::int64_t, 3> cell;
    for (int axis = 0; axis < 3; ++axis) cell[axis] = static_cast<std::int64_t>(std::floor(place[axis] / spacing));
    Merged& sum = grid[cell];
    sum.moment += area * place;
    sum.area += area;
  };
  const std::array<double, 3> sides{side(0), side(1), side(2)};
  const auto shortest = std::ranges::min_element(sides);
  const int n = parts(std::ranges::max(sides)), wide = parts(*shortest);
  const bool is_thin = n > thin_ratio * wide;
  if (is_thin) std::ranges::rotate(corner, corner.begin() + (shortest - sides.begin()));
  const Vec3 along = corner[1] - corner[0], across = corner[2] - corner[0];
  const double area = 0.5 * along.cross(across).norm() / (n * n);
  for (int i = 0; i < n; ++i) {
    const double strip = 2.0 * i + 1.0, middle = (i * (i + 1.0) + 1.0 / 3.0) / (0.5 * strip * n);  // from the tip
    for (int j = 0; is_thin && j < wide; ++j) {
      add(corner[0] + middle * (along + (j + 0.5) / wide * (across - along)), strip / wide * area);
    }
    for (int j = 0; !is_thin && j < n - i; ++j) {
      for (const double third : {1.0 / 3.0, 2.0 / 3.0}) {  // of the triangle, and of the one turned over beside it
        if (third > 0.5 && i + j == n - 1) continue;
        add(corner[0] + (i + third) / n * along + (j + third) / n * across, area);
      }
    }
  }
}

}  // namespace

SurfacePatch sample_surface(const Surface& surface, double spacing, const Contains& inside) {
  if (!(spacing > 0.0) || !std::isfinite(spacing)) {
    throw Error("sample_surface: expected a finite spacing above 0 m, got " + to_decimal(spacing));
  }
  const auto count = static_cast<Index>(surface.vertices.size());
  Grid grid;
  for (std::size_t row = 0; row < surface.triangles.size(); ++row) {
    std::array<Vec3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index vertex = surface.triangles[row][k];
      if (vertex < 0 || vertex >= count || !surface.vertices[vertex].allFinite()) {
        throw Error("sample_surface: triangle " + std::to_string(row) + ": expected vertices from 0 to " +
                    std::to_string(count - 1) + " at finite places, got " + std::to_string(vertex));
      }
      corner[k] = surface.vertices[vertex];
      if (corner[k].cwiseAbs().maxCoeff() <= most_rows * spacing) continue;
      throw Error("sample_surface: expected a surface within 1e15 spacings of the origin, got a spacing of " +
                  to_decimal(spacing) + " m; is it in the wrong unit?");
    }
    add_triangle(corner, spacing, inside, grid);
  }
  SurfacePatch patch;
  for (const auto& [cell, sum] : grid) {
    if (!(sum.area > 0.0)) continue;
    patch.points.push_back(sum.moment / sum.area);
    patch.areas.push_back(sum.area);
  }
  if (patch.points.empty()) {
    throw Error("sample_surface: no part of the surface is inside; check the place, its size and the unit of length");
  }
  return patch;
}

}  // namespace phymul
