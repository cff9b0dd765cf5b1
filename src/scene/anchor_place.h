// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/joint.h>
#include <phymul/tool.h>

#include <algorithm>
#include <span>

namespace phymul {

/// m: of an anchor that fits the scene, with particles at `position` [N] and tools at their last target pose.
inline Vec3 anchor_place(const Anchor& anchor, std::span<const Vec3> position, const std::vector<SceneTool>& tools) {
  if (!anchor.tool.empty()) {
    const ToolPose& pose = std::ranges::find(tools, anchor.tool, &SceneTool::name)->pose;
    return pose.position + pose.orientation * anchor.point;
  }
  if (anchor.particles.empty()) return anchor.point;
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < anchor.particles.size(); ++k) sum += anchor.weights[k] * position[anchor.particles[k]];
  return sum;
}

}  // namespace phymul
