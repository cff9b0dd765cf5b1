// SPDX-License-Identifier: MIT
//
// Triangles of a tool, to be drawn.
#pragma once

#include <phymul/tool.h>

#include <array>
#include <vector>

struct ToolTriangle {
  std::array<phymul::Vec3, 3> place;   ///< m, of the world
  std::array<phymul::Vec3, 3> normal;  ///< outward
};

/// `around`: half of the side of what is drawn of a half-space. A needle has a hub besides. Throws phymul::Error for a
/// distance grid, which does not know its triangles.
std::vector<ToolTriangle> triangles_of(const phymul::ToolShape& shape, const phymul::ToolPose& pose, double around);
