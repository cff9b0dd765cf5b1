// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <array>
#include <cstddef>
#include <span>

namespace phymul {

/// The box that all grids of statics share, and the cells of one of them. Places of cells and of nodes have rows in
/// tables of the whole grid, the longest axis slowest: neighbours have close rows then.
struct GridShape {
  Vec3 origin{0, 0, 0}, spacing{0, 0, 0};  ///< m
  std::array<Index, 3> cells{1, 1, 1};
  std::array<int, 3> slow_to_fast{2, 1, 0};  ///< the axes, the longest first

  /// Cells of about `spacing`, m, over the box of the points.
  static GridShape over(std::span<const Vec3> points, double spacing);
  GridShape coarser() const;  ///< twice the spacing; beyond the box where a number of cells is odd

  /// Of cells, or with `more` = 1 of nodes.
  std::size_t row_of(const std::array<Index, 3>& at, Index more) const;
  std::size_t rows(Index more) const;
  /// Calls visit(at) by rows.
  template <class Visit>
  void for_each_place(Index more, const Visit& visit) const {
    const auto [slow, middle, fast] = slow_to_fast;
    std::array<Index, 3> at;
    for (at[slow] = 0; at[slow] < cells[slow] + more; ++at[slow]) {
      for (at[middle] = 0; at[middle] < cells[middle] + more; ++at[middle]) {
        for (at[fast] = 0; at[fast] < cells[fast] + more; ++at[fast]) visit(at);
      }
    }
  }
};

/// The place of a cell's corner `a`, whose bits are its sides along the axes.
inline std::array<Index, 3> corner_at(std::array<Index, 3> cell, int a) {
  for (int axis = 0; axis < 3; ++axis) cell[axis] += a >> axis & 1;
  return cell;
}

}  // namespace phymul
