// SPDX-License-Identifier: MIT
//
// Rows of tables as devices read them.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace phymul {

using Int4 = std::array<std::int32_t, 4>;
using Int2 = std::array<std::int32_t, 2>;
using Float4 = std::array<float, 4>;
using Float2 = std::array<float, 2>;

inline std::int32_t bits_of(float value) {
  return std::bit_cast<std::int32_t>(value);
}

}  // namespace phymul
