// SPDX-License-Identifier: MIT
#include "packed_rows.h"

#include <algorithm>
#include <bit>

namespace phymul::cpu {

void LaneRows::add(Index rows, int offset_columns) {
  first_ = to_.size();
  to_.resize(first_ + static_cast<std::size_t>(rows) * columns_ * lanes_, 0.0f);
  for (Index row = 0; row < rows; ++row) {
    for (int k = 0; k < offset_columns * lanes_; ++k) at(row, 0, k) = std::bit_cast<float>(unclaimed);
  }
}

void LaneRows::put(Index row, int column, int lane, const Vec3& v) {
  for (int a = 0; a < 3; ++a) put(row, column + a, lane, v[a]);
}

void LaneRows::offset(Index row, int column, int lane, std::int32_t value) {
  at(row, column, lane) = std::bit_cast<float>(value);
}

void fill_idle(Floats& rows, std::size_t first, int columns, int offset_columns, int lanes, std::int32_t idle,
               std::size_t last) {
  const std::size_t stride = static_cast<std::size_t>(columns) * lanes;
  for (std::size_t row = first; row < std::min(last, rows.size()); row += stride) {
    for (std::size_t k = row; k < row + static_cast<std::size_t>(offset_columns) * lanes; ++k) {
      if (std::bit_cast<std::int32_t>(rows[k]) == unclaimed) rows[k] = std::bit_cast<float>(idle);
    }
  }
}

}  // namespace phymul::cpu
