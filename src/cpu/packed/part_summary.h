// SPDX-License-Identifier: MIT
//
// The summaries of the moving pass: one per part, and the reduction over all parts.
#pragma once

#include <algorithm>
#include <span>

#include "cpu/simd/job.h"

namespace phymul::cpu {

/// A line of the caches for each part.
struct alignas(64) PartSummary {
  simd::MoveSummary summary;
};

inline simd::MoveSummary summary_of(std::span<const PartSummary> parts) {
  simd::MoveSummary all;
  for (const auto& [part] : parts) {
    all.acceleration = std::max(all.acceleration, part.acceleration);
    all.force = std::max(all.force, part.force);
    all.speed = std::max(all.speed, part.speed);
    all.motion = std::max(all.motion, part.motion);
    all.displacement = std::max(all.displacement, part.displacement);
    all.runaway = all.runaway || part.runaway;
    all.cut = all.cut || part.cut;
  }
  return all;
}

}  // namespace phymul::cpu
