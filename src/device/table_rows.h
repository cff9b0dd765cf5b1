// SPDX-License-Identifier: MIT
//
// Rows of tables as devices read them.
#pragma once

#include <phymul/types.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>

namespace phymul {

using Int4 = std::array<std::int32_t, 4>;
using Int2 = std::array<std::int32_t, 2>;
using Float4 = std::array<float, 4>;
using Float2 = std::array<float, 2>;

inline std::int32_t bits_of(float value) {
  return std::bit_cast<std::int32_t>(value);
}

/// Infinity, and what is beyond single precision, as its largest number.
inline float to_float(double value) {
  return static_cast<float>(std::min(value, double{std::numeric_limits<float>::max()}));
}

inline Vec3 widened(const Float4& v) {
  return {v[0], v[1], v[2]};
}

inline Float4 float4(const Vec3& v, float w = 0.0f) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), w};
}

/// A place as the sum of two. GCC 12 takes the second for 0 in vectorised code where numbers are cast one by one.
inline std::array<Float4, 2> halves(const Vec3& x) {
  const Eigen::Vector3f high = x.cast<float>(), low = (x - high.cast<double>()).cast<float>();
  return {Float4{high.x(), high.y(), high.z(), 0.0f}, Float4{low.x(), low.y(), low.z(), 0.0f}};
}

}  // namespace phymul
