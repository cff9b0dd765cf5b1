// SPDX-License-Identifier: MIT
//
// root_of_cubic of enclosed_volume.h in float: the twin of glsl/volume/volume_root.glsl, operation by operation.
#pragma once

#include <algorithm>
#include <cmath>

namespace phymul::cpu {

struct VolumeRoot {
  bool found = false;
  float s = 0.0f;
};

/// Where a cubic that grows at 0 ceases to, ahead; 0: it never does.
inline float growing_end(float c1, float c2, float c3) {
  const float under = c2 * c2 - 3.0f * (c3 * c1);
  if (under < 0.0f || (c2 >= 0.0f && c3 >= 0.0f)) return 0.0f;
  const float root = std::sqrt(std::max(under, 0.0f));
  return c2 < 0.0f ? c1 * (1.0f / (root - c2)) : (c2 + root) * (1.0f / (-3.0f * c3));
}

/// The s nearest to 0 with c1 s + c2 s^2 + c3 s^3 = wanted, on the branch through 0 on which the cubic grows. Computed
/// as a way t = |s| ahead.
inline VolumeRoot root_of_cubic(float c1, float c2, float c3, float wanted) {
  const float total = std::abs(wanted) + c1 + std::abs(c2) + std::abs(c3);
  if (!(c1 > 0.0f) || !std::isfinite(total)) return {};
  if (wanted == 0.0f) return {true, 0.0f};
  const float W = std::abs(wanted);
  if (wanted < 0.0f) c2 = -c2;
  const float end = growing_end(c1, c2, c3);
  const bool ends = end > 0.0f;
  const float straight = W * (1.0f / c1);
  float high = ends ? std::min(straight, end) : straight;
  for (int k = 0; k < 64; ++k) {
    if (((c3 * high + c2) * high + c1) * high >= W) break;
    if (k == 63 || (ends && high >= end)) return {};
    high = ends ? std::min(2.0f * high, end) : 2.0f * high;
  }
  // Newton's iteration, kept in between by halving.
  float low = 0.0f, t = std::min(straight, high);
  for (int k = 0; k < 64; ++k) {
    const float ahead = ((c3 * t + c2) * t + c1) * t - W;
    const float slope = (3.0f * c3 * t + 2.0f * c2) * t + c1;
    (ahead < 0.0f ? low : high) = t;
    const float newton = t - ahead * (1.0f / slope);
    const float next = newton > low && newton < high ? newton : 0.5f * (low + high);
    if (ahead == 0.0f || next == t || next == low || next == high) break;
    t = next;
  }
  return {true, wanted < 0.0f ? -t : t};
}

}  // namespace phymul::cpu
