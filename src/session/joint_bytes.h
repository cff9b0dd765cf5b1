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
/// Reads a joint and adds it to the scene. Throws Error if the bytes are damaged or the scene refuses the joint.
void take_joint(ByteReader& in, Scene& scene);

}  // namespace phymul
