// SPDX-License-Identifier: MIT
#include "tool_shape.h"

#include <phymul/distance_grid.h>

#include "grasp.h"
#include "tool_extent.h"
#include "tool_frame.h"

namespace phymul {

std::vector<WithinReach> within_reach(const Tool& tool, const ToolPose& pose, double distance,
                                      const VecList& position) {
  const cpu::ShapeIn<double> shape = cpu::shape_of(tool);
  const cpu::ToolFrame frame(pose);
  std::vector<WithinReach> found;
  for (std::size_t i = 0; i < position.size(); ++i) {
    const Vec3 q = frame.inside(position[i]);
    if (cpu::distance_to(shape, cpu::unpacked(q)).phi <= distance) found.push_back({static_cast<Index>(i), q});
  }
  return found;
}

namespace cpu {
namespace {

GridValues<double> values_of(const DistanceGrid& grid) {
  const auto [nx, ny, nz] = grid.count();
  return {grid.values().data(), nx, ny, nz, unpacked(grid.origin()), grid.spacing()};
}

}  // namespace

ShapeIn<double> shape_of(const Tool& tool) {
  const ToolExtent extent = extent_of(tool);
  ShapeIn<double> shape{.kind = kind_of(tool.shape),
                        .size = unpacked(extent.size),
                        .margin = tool.margin,
                        .thickness = extent.thickness};
  const auto* grid = std::get_if<std::shared_ptr<const DistanceGrid>>(&tool.shape);
  if (grid) shape.grid = values_of(**grid);
  return shape;
}

}  // namespace cpu
}  // namespace phymul
