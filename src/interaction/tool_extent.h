// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/tool.h>

namespace phymul {

/// A tool's shape in numbers, in its own frame; nothing of a needle.
struct ToolExtent {
  Vec3 size{0, 0, 0};                // m; sphere: radius; capsule: radius, length; box: half sizes
  double thickness = 0.0;            // m: a way shorter than half of it cannot pass through
  Vec3 low{0, 0, 0}, high{0, 0, 0};  // m: around it and its margin
};

ToolExtent extent_of(const Tool& tool);

}  // namespace phymul
