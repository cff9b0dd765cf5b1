// SPDX-License-Identifier: MIT
//
// What the parts of a moving pass found, and all of them together.
#pragma once

#include <algorithm>
#include <span>

#include "cpu/simd/job.h"

namespace phymul::cpu {

/// A line of the caches for each part.
struct alignas(64) PartReach {
  simd::Reach reach;
};

inline simd::Reach reach_of_all(std::span<const PartReach> parts) {
  simd::Reach all;
  for (const auto& [part] : parts) {
    all.acceleration = std::max(all.acceleration, part.acceleration);
    all.force = std::max(all.force, part.force);
    all.speed = std::max(all.speed, part.speed);
    all.displacement = std::max(all.displacement, part.displacement);
    all.runaway = all.runaway || part.runaway;
    all.cut = all.cut || part.cut;
  }
  return all;
}

}  // namespace phymul::cpu
