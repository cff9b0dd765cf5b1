// SPDX-License-Identifier: MIT
//
// Filling the rows of simd/job.h: column after column, `lanes` of each.
#pragma once

#include <phymul/types.h>

#include <cstdint>
#include <utility>

#include "device/float_range.h"
#include "packed_body.h"

namespace phymul::cpu {

/// Offsets of lanes that nothing has claimed.
inline constexpr std::int32_t unclaimed = -1;

/// Rows at the end of an array.
class LaneRows {
 public:
  LaneRows(Floats& to, int columns, int lanes) : to_(to), columns_(columns), lanes_(lanes), first_(to.size()) {}

  /// Appends rows of zeros whose offsets are unclaimed; put() and offset() then mean these.
  void add(Index rows, int offset_columns);
  void put(Index row, int column, int lane, double value) { at(row, column, lane) = narrow(value); }
  void put(Index row, int column, int lane, const Vec3& v);  ///< this column and the two after it
  void offset(Index row, int column, int lane, std::int32_t value);

 private:
  float& at(Index row, int column, int lane) {
    return to_[first_ + (static_cast<std::size_t>(row) * columns_ + column) * lanes_ + lane];
  }

  Floats& to_;
  int columns_, lanes_;
  std::size_t first_;
};

/// Points what is unclaimed among the rows from `first` on, up to `last`, to `idle`.
void fill_idle(Floats& rows, std::size_t first, int columns, int offset_columns, int lanes, std::int32_t idle,
               std::size_t last = static_cast<std::size_t>(-1));

/// Terms that are neighbours share particles, and adding to one place in lane after lane would wait for each other: so
/// a lane takes a run of terms, and a row takes its terms far from each other.
class SpreadLanes {
 public:
  SpreadLanes(std::size_t terms, int lanes) : rows_(static_cast<int>((terms + lanes - 1) / lanes)) {}
  int rows() const { return rows_; }
  std::pair<Index, int> place(std::size_t term) const {
    return {static_cast<Index>(term % rows_), static_cast<int>(term / rows_)};
  }

 private:
  int rows_;
};

}  // namespace phymul::cpu
