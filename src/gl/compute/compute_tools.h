// SPDX-License-Identifier: MIT
//
// The tools of a scene among the rows of its loads: laws, frames per instant, particles as tools see them, grids, and,
// where they act on the device, what the particles do to each.
#pragma once

#include "compute_tables.h"
#include "device/float_tools.h"

namespace phymul::gl {

class ComputeTools {
 public:
  static constexpr int most_parts = 64;  ///< that a tool's sums are cut to

  /// `acts`: on the device; else joints alone look where they are.
  ComputeTools(const FloatTools& tools, bool acts, const ComputeTables& tables, StorageRows& rows);

  bool act() const { return acts_; }

  int count() const { return count_; }
  bool any_grid() const { return any_grid_; }

  void write_held(const FloatTools& tools, StorageBuffer& buffer) const;
  void write_frames(const FloatTools& tools, StorageBuffer& buffer) const;

  std::int64_t sums_row() const { return sums_row_; }    ///< [count][places][4]
  std::int64_t parts_row() const { return parts_row_; }  ///< [count][parts][4]
  std::int64_t total_row() const { return total_row_; }  ///< [count][4]

 private:
  const ComputeTables* tables_;
  int count_;
  bool acts_, any_grid_;
  std::int64_t frames_row_, held_row_, sums_row_ = 0, parts_row_ = 0, total_row_ = 0;
};

}  // namespace phymul::gl
