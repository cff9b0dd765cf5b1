// SPDX-License-Identifier: MIT
//
// Solids in closed form, and what is made of them.
#include <phymul/body.h>
#include <phymul/error.h>
#include <phymul/surface_patch.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>

#include "base/decimal.h"
#include "filling.h"
#include "interior.h"
#include "model/closed_surface.h"

namespace phymul {
namespace {

void require_finite(const char* what, const Vec3& x) {
  if (!x.allFinite()) throw Error(std::string(what) + ": expected finite coordinates, got " + place_text(x));
}

void require_above_0(const char* what, const char* name, double value) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw Error(std::string(what) + ": expected a " + name + " above 0 m, got " + length_text(value));
}

void require_solid(const char* what, const Solid& solid) {
  if (!solid.distance) throw Error(std::string(what) + ": a solid has no distance function");
  if ((solid.low.array() < solid.high.array()).all()) return;
  throw Error(std::string(what) + ": expected a box with low below high, got " + place_text(solid.low) + " to " +
              place_text(solid.high));
}

using Distances = std::vector<Solid>;

/// Of several solids the smallest distance or the largest.
template <class Better>
Solid joined(const char* what, Distances solids, Better better) {
  if (solids.empty()) throw Error(std::string(what) + ": expected at least one solid, got none");
  for (const Solid& solid : solids) require_solid(what, solid);
  Solid all;
  all.low = solids.front().low;
  all.high = solids.front().high;
  const auto shared = std::make_shared<const Distances>(std::move(solids));
  all.distance = [shared, better](const Vec3& x) {
    double value = clipped_distance(shared->front(), x);
    for (std::size_t k = 1; k < shared->size(); ++k) {
      const double own = clipped_distance((*shared)[k], x);
      value = std::isnan(own) ? own : better(value, own);
    }
    return value;
  };
  return all;
}

}  // namespace

Solid solid_ball(const Vec3& centre, double radius) {
  return solid_capsule(centre, centre, radius);
}

Solid solid_ellipsoid(const Vec3& centre, const Vec3& semi_axes) {
  require_finite("solid_ellipsoid", centre);
  for (const double axis : semi_axes) require_above_0("solid_ellipsoid", "semi-axis", axis);
  const double least = semi_axes.minCoeff();
  return {[=](const Vec3& x) { return least * ((x - centre).cwiseQuotient(semi_axes).norm() - 1.0); },
          centre - semi_axes, centre + semi_axes};
}

Solid solid_capsule(const Vec3& a, const Vec3& b, double radius) {
  require_finite("solid_capsule", a);
  require_finite("solid_capsule", b);
  require_above_0("solid_capsule", "radius", radius);
  const Vec3 along = b - a;
  const double squared = along.squaredNorm();
  const auto distance = [=](const Vec3& x) {
    const double share = squared > 0.0 ? std::clamp((x - a).dot(along) / squared, 0.0, 1.0) : 0.0;
    return (x - a - share * along).norm() - radius;
  };
  return {distance, a.cwiseMin(b) - Vec3::Constant(radius), a.cwiseMax(b) + Vec3::Constant(radius)};
}

Solid solid_box(const Vec3& low, const Vec3& high) {
  require_finite("solid_box", low);
  require_finite("solid_box", high);
  for (int k = 0; k < 3; ++k) require_above_0("solid_box", "side", high[k] - low[k]);
  const Vec3 middle = 0.5 * (low + high), half = 0.5 * (high - low);
  return {[=](const Vec3& x) {
            const Vec3 out = (x - middle).cwiseAbs() - half;
            return out.cwiseMax(0.0).norm() + std::min(out.maxCoeff(), 0.0);
          },
          low, high};
}

Solid solid_within(Surface surface) {
  mend_surface(surface);
  const VecList& x = surface.vertices;
  Eigen::AlignedBox3d box;
  for (const auto& [a, b, c] : surface.triangles) {
    box.extend(x[a]).extend(x[b]).extend(x[c]);
  }
  if (const Index flat = flat_triangle(x, surface.triangles); flat >= 0) {
    throw Error("solid_within: the triangle at " + place_text(x[surface.triangles[flat][0]]) +
                " has no area; remesh the surface");
  }
  if (const auto [a, b] = open_edge(surface.triangles); a >= 0) {
    throw Error("solid_within: shells touch along the edge from " + place_text(x[a]) + " to " + place_text(x[b]) +
                "; move them apart, or join them by a boolean union");
  }
  // Overlaps along common faces, which mend_surface() does not see, are refused.
  const CentredLattice lattice = lattice_over(box.min(), box.max(), {.spacing = box.sizes().maxCoeff() / 64.0});
  SurfaceInterior(surface, lattice).inside(lattice);
  const auto closest = std::make_shared<const ClosestTriangle>(x, surface.triangles);
  return {[closest](const Vec3& at) { return closest->signed_distance(at); }, box.min(), box.max()};
}

Solid solid_union(std::vector<Solid> solids) {
  Eigen::AlignedBox3d box;
  for (const Solid& solid : solids) box.extend(Eigen::AlignedBox3d(solid.low, solid.high));
  Solid all = joined("solid_union", std::move(solids), [](double a, double b) { return std::min(a, b); });
  all.low = box.min();
  all.high = box.max();
  return all;
}

Solid solid_intersection(std::vector<Solid> solids) {
  // The box of any of them holds it; the smallest costs least.
  const auto least = std::ranges::min_element(
      solids, {}, [](const Solid& solid) { return (solid.high - solid.low).cwiseMax(0.0).prod(); });
  if (least != solids.end()) std::iter_swap(solids.begin(), least);
  return joined("solid_intersection", std::move(solids), [](double a, double b) { return std::max(a, b); });
}

Solid solid_difference(Solid solid, Solid hole) {
  require_solid("solid_difference", hole);
  const auto outside = [hole = std::move(hole)](const Vec3& x) { return -clipped_distance(hole, x); };
  const Vec3 low = solid.low, high = solid.high;
  return joined("solid_difference", {std::move(solid), {outside, low, high}},
                [](double a, double b) { return std::max(a, b); });
}

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
