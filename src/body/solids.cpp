// SPDX-License-Identifier: MIT
//
// Solids in closed form, and what is made of them.
#include <phymul/body.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/place_text.h"
#include "filling.h"
#include "interior.h"
#include "model/closest_triangle.h"
#include "surface_interior.h"

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

}  // namespace phymul
