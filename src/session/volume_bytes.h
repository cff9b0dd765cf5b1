// SPDX-License-Identifier: MIT
//
// Volume constraints in recordings.
#pragma once

#include <phymul/scene.h>

#include <span>

#include "base/checked_file.h"

namespace phymul {

/// What makes a scene with the volumes `before` one with those of `scene`.
void put_volumes(ByteWriter& out, const Scene& scene, std::span<const VolumeConstraint> before);
void take_volumes(ByteReader& in, Scene& scene);
void take_old_volumes(ByteReader& in, Scene& scene);  ///< as files had them before fluids

}  // namespace phymul
