// SPDX-License-Identifier: MIT
#include "liver_shape.h"

#include <phymul/surface.h>

#include <algorithm>

using phymul::Index;
using phymul::Vec3;

namespace {

/// Positive outside, about in metres near the surface.
double from_ellipsoid(const Vec3& x, const Vec3& middle, const Vec3& semi_axes) {
  return ((x - middle).cwiseQuotient(semi_axes).norm() - 1.0) * semi_axes.minCoeff();
}

}  // namespace

phymul::Solid liver() {
  const auto distance = [](const Vec3& x) {
    const double right = from_ellipsoid(x, {0.035, 0.0, 0.0}, {0.075, 0.065, 0.058});
    const double left = from_ellipsoid(x, {-0.055, 0.005, 0.018}, {0.085, 0.045, 0.026});
    const double blend = 0.02, h = std::clamp(0.5 + 0.5 * (left - right) / blend, 0.0, 1.0);
    const double lobes = left + (right - left) * h - blend * h * (1.0 - h);
    return std::max(lobes, 0.11 - (x - Vec3(-0.03, -0.01, -0.135)).norm());
  };
  return {distance, {-0.15, -0.08, -0.07}, {0.12, 0.08, 0.07}};
}

phymul::Surface liver_surface(double spacing) {
  const phymul::Model fine = phymul::make_body(liver(), {.spacing = spacing});
  phymul::Surface surface;
  surface.triangles = phymul::surface_triangles(fine);
  std::vector<Index> row(fine.rest.size(), -1);
  for (auto& corners : surface.triangles) {
    for (Index& i : corners) {
      if (row[i] < 0) {
        row[i] = static_cast<Index>(surface.vertices.size());
        surface.vertices.push_back(fine.rest[i]);
      }
      i = row[i];
    }
  }
  return surface;
}
