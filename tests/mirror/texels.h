// SPDX-License-Identifier: MIT
//
// What a row of a table holds, as a shader reads it.
#pragma once

#include <bit>
#include <cstdint>

#include "base/vector3.h"
#include "device/table_rows.h"

namespace phymul::cpu {

using Float3 = Vector3<float>;

inline Float3 xyz(const Float4& row) {
  return {row[0], row[1], row[2]};
}

inline float as_float(std::int32_t bits) {
  return std::bit_cast<float>(bits);
}

}  // namespace phymul::cpu
