// SPDX-License-Identifier: MIT
//
// A scene in bytes, load by load. A change of a scene is: whether it starts from an empty one (u8), gravity, contacts,
// the number of loads (u64), the changed ones (count, then row and load each), and after an empty one the kept volumes.
#pragma once

#include <phymul/scene.h>

#include "checked_file.h"

namespace phymul {

std::string load_bytes(const Load& load);
Load take_load(ByteReader& in);  ///< throws Error for a value that no load has; the scene checks the rest

std::string volume_bytes(const Scene& scene);

/// The change from a scene of these loads (load_bytes of each) to `scene`; `anew`: from an empty one.
std::string scene_change_bytes(const Scene& scene, const std::vector<std::string>& loads, bool anew);

/// Makes such a change. Throws Error for bytes that are none, or that the scene refuses.
void change_scene(Scene& scene, ByteReader& in);

}  // namespace phymul
