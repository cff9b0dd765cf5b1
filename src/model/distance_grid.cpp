// SPDX-License-Identifier: MIT
#include <phymul/distance_grid.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "closed_surface.h"
#include "outer_faces.h"

namespace phymul {
namespace {

/// 256 MiB of distances; a finer grid than that is a mistake in the units.
constexpr double most_corners = 64.0 * 1024 * 1024;
constexpr int cubes_around = 2;

[[noreturn]] void refuse(const std::string& what) {
  throw Error("distance grid: " + what);
}

std::vector<Triangle> triangles_of(const Model& model) {
  std::vector<Triangle> triangles = outward_triangles(model);
  if (const Index flat = flat_triangle(model.rest, triangles); flat >= 0) {
    const Triangle& t = triangles[flat];
    refuse("the triangle of particles " + std::to_string(t[0]) + ", " + std::to_string(t[1]) + " and " +
           std::to_string(t[2]) + " has no area");
  }
  return triangles;
}

}  // namespace

DistanceGrid::DistanceGrid(const Vec3& origin, double spacing, const std::array<int, 3>& count,
                           std::vector<float> values)
    : origin_(origin), spacing_(spacing), count_(count), values_(std::move(values)) {
  if (!origin.allFinite() || !(spacing > 0.0) || !std::isfinite(spacing)) {
    refuse("expected a finite origin and a spacing above 0 m, got a spacing of " + to_decimal(spacing));
  }
  std::size_t corners = 1;
  for (const int n : count) {
    if (n < 2) refuse("expected at least 2 corners along each axis, got " + std::to_string(n));
    if (corners > values_.size() / static_cast<std::size_t>(n)) {
      refuse("expected a value for each corner of the grid, got " + std::to_string(values_.size()));
    }
    corners *= static_cast<std::size_t>(n);
  }
  if (values_.size() != corners) {
    refuse("expected " + std::to_string(corners) + " values, got " + std::to_string(values_.size()));
  }
  if (!std::ranges::all_of(values_, [](float v) { return std::isfinite(v); })) refuse("expected finite values");
  depth_ = -*std::ranges::min_element(values_);
  if (!(depth_ > 0.0)) refuse("no corner lies inside the shape; expected a spacing smaller than its thinnest part");
}

std::shared_ptr<const DistanceGrid> make_distance_grid(const Model& surface, double spacing) {
  validate(surface);
  if (surface.dimension == 2) refuse("expected a surface in three dimensions");
  if (!(spacing > 0.0) || !std::isfinite(spacing)) refuse("expected a spacing above 0 m, got " + to_decimal(spacing));
  std::vector<Triangle> triangles = triangles_of(surface);
  if (triangles.empty()) refuse("expected triangles, quads or volume cells, got a model without");
  const auto [a, b] = open_edge(triangles);
  if (a >= 0) {
    refuse("the surface is not closed, or not wound one way: the edge from particle " + std::to_string(a) + " to " +
           std::to_string(b) + " does not have one triangle on each side");
  }
  if (enclosed_volume(triangles, surface.rest) < 0.0) {
    for (Triangle& t : triangles) std::swap(t[1], t[2]);
  }
  Eigen::AlignedBox3d box;
  for (const Triangle& t : triangles) {
    for (const Index i : t) box.extend(surface.rest[i]);
  }
  const Vec3 cubes = (box.sizes() / spacing).array().ceil() + 2.0 * cubes_around;
  if (!((cubes.array() + 1.0).prod() <= most_corners)) {
    refuse("a spacing of " + to_decimal(spacing) + " m gives more than 64 million corners; take a larger one");
  }
  const std::array<int, 3> count{static_cast<int>(cubes.x()) + 1, static_cast<int>(cubes.y()) + 1,
                                 static_cast<int>(cubes.z()) + 1};
  const Vec3 origin = box.center() - 0.5 * spacing * cubes;
  const ClosestTriangle closest(surface.rest, triangles);
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(count[0]) * count[1] * count[2]);
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        values.push_back(static_cast<float>(closest.signed_distance(origin + spacing * Vec3(i, j, k))));
      }
    }
  }
  return std::make_shared<const DistanceGrid>(origin, spacing, count, std::move(values));
}

}  // namespace phymul
