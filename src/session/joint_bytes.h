// SPDX-License-Identifier: MIT
//
// The joints of a scene in bytes.
#pragma once

#include <phymul/scene.h>

#include "base/checked_file.h"

namespace phymul {

/// What a JointHandle can change: stiffness, damping (f64), rest lengths (count u64, f64 each).
std::string joint_value_bytes(const Joint& joint);
void change_joint_values(const JointHandle& joint, ByteReader& in);

void put_joint(ByteWriter& out, const SceneJoint& joint);
/// Adds it. Throws Error for bytes that are none, or a joint that the scene refuses.
void take_joint(ByteReader& in, Scene& scene);

}  // namespace phymul
