// SPDX-License-Identifier: MIT
//
// The tools of a scene among the rows of its loads: laws, frames per instant, particles as tools see them, grids, and
// what the particles do to each.
#pragma once

#include "compute_tables.h"
#include "device/float_tools.h"

namespace phymul::gl {

class ComputeTools {
 public:
  static constexpr int most_parts = 64;  ///< that a tool's sums are cut to

  /// Takes rows from `first` on.
  ComputeTools(const FloatTools& tools, std::int64_t first, const ComputeTables& tables);

  std::int64_t end() const { return end_; }
  int count() const { return count_; }
  int needle_count() const { return needle_count_; }
  bool any_grid() const { return any_grid_; }

  /// All but frames, which change with every batch.
  void write(const FloatTools& tools, StorageBuffer& rows) const;
  void write_held(const FloatTools& tools, StorageBuffer& rows) const;
  void write_frames(const FloatTools& tools, StorageBuffer& rows) const;
  void place(Kernel& kernel) const;

  std::int64_t sums_row() const { return sums_row_; }    ///< [count][places][4]
  std::int64_t parts_row() const { return parts_row_; }  ///< [count][parts][4]
  std::int64_t total_row() const { return total_row_; }  ///< [count][4]

 private:
  std::vector<Float4> by_place(const std::vector<Float4>& by_particle, std::size_t rows_each) const;

  const ComputeTables* tables_;
  int count_, needle_count_;
  bool any_grid_;
  std::int64_t laws_row_ = 0, frames_row_ = 0, rest_row_ = 0, held_row_ = 0, grid_row_ = 0;
  std::int64_t sums_row_ = 0, parts_row_ = 0, total_row_ = 0, end_ = 0;
};

}  // namespace phymul::gl
