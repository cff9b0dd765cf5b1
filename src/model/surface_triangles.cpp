// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "surface_facets.h"

namespace phymul {
namespace {

Vec3 area_of(const std::array<Index, 3>& t, std::span<const Vec3> x) {
  return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

/// A ring of three or four particles as one or two triangles.
void append_ring(const std::vector<Index>& ring, std::vector<std::array<Index, 3>>& triangles) {
  for (std::size_t k = 2; k < ring.size(); ++k) triangles.push_back({ring[0], ring[k - 1], ring[k]});
}

std::vector<std::array<Index, 3>> plane_triangles(const Model& model) {
  std::vector<std::array<Index, 3>> triangles;
  for (const Cell& cell : model.cells) {
    if (cell.share == 0.0 || (cell.type != CellType::triangle && cell.type != CellType::quad)) continue;
    const std::size_t first = triangles.size();
    append_ring(cell.particles, triangles);
    double area = 0.0;
    for (std::size_t t = first; t < triangles.size(); ++t) area += area_of(triangles[t], model.rest).z();
    if (area >= 0.0) continue;
    for (std::size_t t = first; t < triangles.size(); ++t) std::swap(triangles[t][1], triangles[t][2]);
  }
  return triangles;
}

}  // namespace

Vec3 ring_area(std::span<const Index> ring, std::span<const Vec3> position) {
  Vec3 area = Vec3::Zero();
  for (std::size_t k = 2; k < ring.size(); ++k) area += area_of({ring[0], ring[k - 1], ring[k]}, position);
  return area;
}

std::vector<std::array<Index, 3>> outward_triangles(const Model& model) {
  std::vector<std::array<Index, 3>> triangles;
  for (Facet& facet : surface_facets(model, std::vector<char>(model.rest.size(), 1))) {
    // A facet has the winding of its cell, which may be inside out, and an area that points outward all the same.
    if (ring_area(facet.particles, model.rest).dot(facet.area) < 0.0) std::ranges::reverse(facet.particles);
    append_ring(facet.particles, triangles);
  }
  return triangles;
}

std::vector<std::array<Index, 3>> surface_triangles(const Model& model) {
  validate(model);
  return model.dimension == 2 ? plane_triangles(model) : outward_triangles(model);
}

void surface_normals(std::span<const std::array<Index, 3>> triangles, std::span<const Vec3> position, VecList& normal) {
  const auto count = static_cast<Index>(position.size());
  normal.assign(position.size(), Vec3::Zero());
  for (const std::array<Index, 3>& triangle : triangles) {
    for (const Index i : triangle) {
      if (i >= 0 && i < count) continue;
      throw Error("surface_normals: expected triangles of particles 0 to " + std::to_string(count - 1) + ", got " +
                  std::to_string(i) + "; are triangles and positions of one model?");
    }
    const Vec3 area = area_of(triangle, position);
    for (const Index i : triangle) normal[i] += area;
  }
  for (Vec3& n : normal) n.stableNormalize();
}

Index pick_particle(std::span<const Vec3> position, const PickRay& ray) {
  const double length = ray.direction.stableNorm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw Error("pick_particle: expected a ray with a finite direction that is not zero");
  }
  const Vec3 along = ray.direction / length;
  Index nearest = -1;
  double least = 0.0;
  for (std::size_t i = 0; i < position.size(); ++i) {
    const Vec3 to = position[i] - ray.origin;
    const double way = to.dot(along);
    if (!(way >= 0.0) || (nearest >= 0 && way >= least)) continue;
    if (!((to - way * along).norm() <= ray.reach + ray.widening * way)) continue;
    nearest = static_cast<Index>(i);
    least = way;
  }
  return nearest;
}

}  // namespace phymul
