// SPDX-License-Identifier: MIT
#include "tool_shape.h"

#include <phymul/distance_grid.h>
#include <phymul/error.h>
#include <phymul/surface.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/decimal.h"
#include "tool_frame.h"

namespace phymul {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

ToolExtent extent(const Sphere& sphere) {
  const double r = sphere.radius;
  return {.size = {r, 0, 0}, .thickness = r, .low = {-r, -r, -r}, .high = {r, r, r}};
}
ToolExtent extent(const Capsule& capsule) {
  const double r = capsule.radius;
  return {.size = {r, capsule.length, 0}, .thickness = r, .low = {-r, -r, -r}, .high = {r, r, capsule.length + r}};
}
ToolExtent extent(const HalfSpace&) {
  return {.thickness = infinite, .low = Vec3::Constant(-infinite), .high = Vec3::Constant(infinite)};
}
ToolExtent extent(const Box& box) {
  return {.size = box.half_size, .thickness = box.half_size.minCoeff(), .low = -box.half_size, .high = box.half_size};
}
ToolExtent extent(const std::shared_ptr<const DistanceGrid>& grid) {
  const auto [nx, ny, nz] = grid->count();
  return {.thickness = std::min(grid->depth(), grid->spacing()),
          .low = grid->origin(),
          .high = grid->origin() + grid->spacing() * Vec3(nx - 1, ny - 1, nz - 1)};
}
ToolExtent extent(const Needle& needle) {  // its shaft, or the whole circle
  const double r = needle.arc_radius;
  if (r > 0.0) return {.low = {0, 0, -r}, .high = {2 * r, 0, r}};
  return {.high = {0, 0, needle.length}};
}
ToolExtent extent(const Blade& blade) {
  return {.low = {-0.5 * blade.width, std::min(0.0, -blade.bow), std::min(0.0, blade.belly)},
          .high = {0.5 * blade.width, std::max(0.0, -blade.bow), std::max(0.0, blade.belly) + blade.height}};
}

/// m, of the circle over a chord whose middle is so far from the arc; with the sign of `sagitta`, 0 for none.
double radius_over(double chord, double sagitta) {
  return sagitta == 0.0 ? 0.0 : 0.5 * (0.25 * chord * chord / sagitta + sagitta);
}

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

}  // namespace

BladeCurve::BladeCurve(const Blade& blade) : length_(blade.width), radius_(radius_over(blade.width, blade.bow)) {
  if (radius_ != 0.0)
    length_ = 2.0 * std::abs(radius_) * std::asin(std::min(1.0, 0.5 * blade.width / std::abs(radius_)));
  bend_ = radius_over(length_, blade.belly);
}

double BladeCurve::slope(double along) const {
  if (bend_ == 0.0) return 0.0;
  return along / std::copysign(std::sqrt(std::max(bend_ * bend_ - along * along, 1e-12 * bend_ * bend_)), bend_);
}

/// As a line from the ends of the arc on.
double BladeCurve::behind(double along) const {
  if (bend_ == 0.0) return 0.0;
  const double u = std::clamp(along, -0.5 * length_, 0.5 * length_);
  return bend_ - std::copysign(std::sqrt(std::max(0.0, bend_ * bend_ - u * u)), bend_);
}

Vec3 BladeCurve::at(double along) const {
  if (radius_ == 0.0) return {along, 0.0, behind(along)};
  const double angle = along / radius_;
  return {radius_ * std::sin(angle), radius_ * (std::cos(angle) - 1.0), behind(along)};
}

Vec3 BladeCurve::way(double along) const {
  const double tilt = slope(along), angle = radius_ == 0.0 ? 0.0 : along / radius_;
  return Vec3(tilt * std::cos(angle), -tilt * std::sin(angle), -1.0) / std::sqrt(1.0 + tilt * tilt);
}

Vec3 BladeCurve::normal(double along) const {
  const double angle = radius_ == 0.0 ? 0.0 : along / radius_;
  return {std::sin(angle), std::cos(angle), 0.0};
}

double BladeCurve::stretch(double along) const {
  const double tilt = slope(along);
  return std::sqrt(1.0 + tilt * tilt);
}

/// Beyond a quarter of a circle from the middle the surface continues straight: a whole circle would also cut on the
/// side opposite the edge.
Vec3 BladeCurve::unrolled(const Vec3& x) const {
  Vec3 unrolled = x;
  if (radius_ != 0.0) {
    const double side = std::copysign(1.0, radius_), out = x.y() + radius_;
    const double ahead = std::max(0.0, side * out), beyond = ahead - side * out;
    unrolled.x() = std::abs(radius_) * std::atan2(x.x(), ahead) + std::copysign(beyond, x.x());
    unrolled.y() = side * std::hypot(x.x(), ahead) - radius_;
  }
  unrolled.z() -= behind(unrolled.x());
  return unrolled;
}

std::string_view beyond_pressing(const Tool& tool) {
  if (std::holds_alternative<Needle>(tool.shape)) return "is a needle";
  if (std::holds_alternative<Blade>(tool.shape)) return "is a blade";
  return tool.suction > 0.0 ? "draws tissue" : "";
}

ToolExtent extent_of(const Tool& tool) {
  ToolExtent own = std::visit([](const auto& shape) { return extent(shape); }, tool.shape);
  own.thickness += tool.margin;
  own.low.array() -= tool.margin;
  own.high.array() += tool.margin;
  return own;
}

std::vector<GraspedParticle> particles_to_grasp(const Tool& tool, const ToolPose& pose, double distance,
                                                const VecList& position) {
  const ShapeIn<double> shape = shape_of(tool);
  const ToolFrame frame(pose);
  std::vector<GraspedParticle> found;
  for (std::size_t i = 0; i < position.size(); ++i) {
    const Vec3 q = frame.inside(position[i]);
    if (distance_to(shape, unpacked(q)).phi <= distance) found.push_back({static_cast<Index>(i), q});
  }
  return found;
}

std::optional<double> least_radius(const ToolShape& shape) {
  struct Radius {
    std::optional<double> operator()(const Sphere& sphere) const { return sphere.radius; }
    std::optional<double> operator()(const Capsule& capsule) const { return capsule.radius; }
    std::optional<double> operator()(const Box& box) const { return box.half_size.minCoeff(); }
    std::optional<double> operator()(const std::shared_ptr<const DistanceGrid>&) const { return 0.0; }
    std::optional<double> operator()(const HalfSpace&) const { return {}; }
    std::optional<double> operator()(const Needle&) const { return {}; }
    std::optional<double> operator()(const Blade&) const { return {}; }
  };
  return std::visit(Radius{}, shape);
}

double least_margin(const Model& model, const ToolShape& shape, double stretch) {
  if (!(stretch > 0.0) || !std::isfinite(stretch)) {
    throw Error("least_margin: expected a finite stretch above 0; got " + to_decimal(stretch));
  }
  const auto triangles = surface_triangles(model);
  if (triangles.empty()) {
    throw Error(
        "least_margin: expected a body with a surface; the model has neither volume cells nor triangles and quads");
  }
  const std::optional<double> radius = least_radius(shape);
  if (!radius) return 0.0;
  double largest = 0.0;
  for (const auto& [a, b, c] : triangles) {
    largest = std::max(largest, covering_radius(model.rest[a], model.rest[b], model.rest[c]));
  }
  return std::max(0.0, stretch * largest - *radius);
}

namespace {

GridValues<double> values_of(const DistanceGrid& grid) {
  const auto [nx, ny, nz] = grid.count();
  return {grid.values().data(), nx, ny, nz, unpacked(grid.origin()), grid.spacing()};
}

}  // namespace

ShapeIn<double> shape_of(const Tool& tool) {
  const ToolExtent extent = extent_of(tool);
  ShapeIn<double> shape{
      .kind = kind_of(tool.shape), .size = unpacked(extent.size), .margin = tool.margin, .thickness = extent.thickness};
  const auto* grid = std::get_if<std::shared_ptr<const DistanceGrid>>(&tool.shape);
  if (grid) shape.grid = values_of(**grid);
  return shape;
}

}  // namespace phymul
