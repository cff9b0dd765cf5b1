// SPDX-License-Identifier: MIT
//
// Tools in bytes: what a scene says of one, where it is, what a solver remembers of it.
#pragma once

#include <phymul/tool.h>

#include "base/checked_file.h"

namespace phymul {

void put_pose(ByteWriter& out, const ToolPose& pose);
ToolPose take_pose(ByteReader& in);

/// The shape's code (u8), then the members of the shape, pose and coefficients.
void put_tool(ByteWriter& out, const Tool& tool);
Tool take_tool(ByteReader& in);  ///< throws Error for a shape there is none of; the scene checks the rest

void put_tool_state(ByteWriter& out, const ToolState& state);
ToolState take_tool_state(ByteReader& in);  ///< throws Error for lists that do not fit together

}  // namespace phymul
