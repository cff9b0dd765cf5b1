// SPDX-License-Identifier: MIT
//
// What a tool takes hold of: for backends whose positions are elsewhere. Defined in src/interaction/tool_shape.cpp,
// where distances are.
#pragma once

#include <phymul/tool.h>

#include <vector>

namespace phymul {

struct WithinReach {
  Index particle = 0;
  Vec3 at{0, 0, 0};  ///< in the tool's frame, m
};

/// Of the positions those within `distance` of the tool's surface, or inside, in order. Nothing for a needle to call.
std::vector<WithinReach> within_reach(const Tool& tool, const ToolPose& pose, double distance, const VecList& position);

}  // namespace phymul
