// SPDX-License-Identifier: MIT
#include "tool_extent.h"

#include <phymul/distance_grid.h>

#include <algorithm>
#include <limits>

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
ToolExtent extent(const Needle&) {
  return {};
}

}  // namespace

ToolExtent extent_of(const Tool& tool) {
  ToolExtent own = std::visit([](const auto& shape) { return extent(shape); }, tool.shape);
  own.thickness += tool.margin;
  own.low.array() -= tool.margin;
  own.high.array() += tool.margin;
  return own;
}

}  // namespace phymul
