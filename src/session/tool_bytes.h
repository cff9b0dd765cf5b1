// SPDX-License-Identifier: MIT
//
// Tools in bytes: what a scene says of one, where it is, what a solver remembers of it.
#pragma once

#include <phymul/tool.h>

#include "base/checked_file.h"

namespace phymul {

/// For a ByteWriter and a pose that is const, or a ByteReader and one that is not.
template <class Bytes, class Pose>
void pose_fields(Bytes& bytes, Pose& pose) {
  bytes.field(pose.position, "a tool's position");
  for (int k = 0; k < 4; ++k) bytes.field(pose.orientation.coeffs()[k], "a tool's orientation");  // x, y, z, w
  bytes.field(pose.velocity, "a tool's velocity");
  bytes.field(pose.spin, "a tool's spin");
}

/// The shape's code (u8), then the members of the shape, pose and coefficients.
void tool_fields(ByteWriter& out, const Tool& tool);
void tool_fields(ByteReader& in, Tool& tool);  ///< throws Error for a shape there is none of; the scene checks the rest

void put_tool_state(ByteWriter& out, const ToolState& state);
ToolState take_tool_state(ByteReader& in);  ///< throws Error for lists that do not fit together

}  // namespace phymul
