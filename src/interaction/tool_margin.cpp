// SPDX-License-Identifier: MIT
//
// How much a tool is to be widened, so that it does not slip between the particles of a surface.
#include <phymul/error.h>
#include <phymul/surface.h>
#include <phymul/tool.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/decimal.h"

namespace phymul {
namespace {

/// m: how far a point of the triangle can be from its nearest corner. Where no angle is obtuse that point is the centre
/// of the circle through the corners; else that lies outside, and the point is where the upright over the middle of a
/// short side meets the longest one: of the two such points the one farther off.
double covering_radius(const Vec3& a, const Vec3& b, const Vec3& c) {
  std::array<double, 3> squares{(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
  std::ranges::sort(squares);
  const auto& [s0, s1, s2] = squares;
  if (!(s2 > 0.0)) return 0.0;
  if (s2 < s0 + s1) {
    const double twice_area = (b - a).cross(c - a).norm();
    return std::sqrt(s0 * s1 * s2) / (2.0 * twice_area);
  }
  // Along the longest side, from the end where the side of square s meets it: half of s over that side's cosine.
  const double longest = std::sqrt(s2);
  const auto along = [&](double s, double other) { return s * longest / (s2 + s - other); };
  return std::max(along(s0, s1), along(s1, s0));
}

/// m: a ball of this radius goes wherever the shape goes through a surface; none: the shape needs no margin.
std::optional<double> least_radius(const Sphere& sphere) {
  return sphere.radius;
}
std::optional<double> least_radius(const Capsule& capsule) {
  return capsule.radius;
}
std::optional<double> least_radius(const Box& box) {
  return box.half_size.minCoeff();
}
std::optional<double> least_radius(const std::shared_ptr<const DistanceGrid>&) {
  return 0.0;
}
std::optional<double> least_radius(const HalfSpace&) {
  return {};
}
std::optional<double> least_radius(const Needle&) {
  return {};
}

}  // namespace

double least_margin(const Model& model, const ToolShape& shape, double stretch) {
  if (!(stretch > 0.0) || !std::isfinite(stretch)) {
    throw Error("least_margin: expected a finite stretch above 0; got " + to_decimal(stretch));
  }
  const auto triangles = surface_triangles(model);
  if (triangles.empty()) {
    throw Error(
        "least_margin: expected a body with a surface; the model has neither volume cells nor triangles and quads");
  }
  const std::optional<double> radius = std::visit([](const auto& own) { return least_radius(own); }, shape);
  if (!radius) return 0.0;
  double largest = 0.0;
  for (const auto& [a, b, c] : triangles) {
    largest = std::max(largest, covering_radius(model.rest[a], model.rest[b], model.rest[c]));
  }
  return std::max(0.0, stretch * largest - *radius);
}

}  // namespace phymul
