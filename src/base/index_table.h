// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <utility>
#include <vector>

namespace phymul {

/// From the number a file gives a thing to its row. Numbers need neither start at 0 nor be consecutive; memory goes
/// with their count, not with their size.
class IndexTable {
 public:
  IndexTable() = default;

  /// `numbers`: [rows], -1: has none. Of equal numbers the first row is found, the others are listed by repeats().
  explicit IndexTable(const std::vector<Index>& numbers);

  /// Row of a number; -1: none.
  Index find(std::int64_t number) const;

  /// Rows whose number an earlier row has, and that earlier row.
  const std::vector<std::pair<Index, Index>>& repeats() const { return repeats_; }

  /// Rows of all numbers in [first, last], in the order of the numbers. Stops before `missing`, the first number of the
  /// range that no row has (-1 where all have one).
  std::vector<Index> find_range(std::int64_t first, std::int64_t last, std::int64_t& missing) const;

 private:
  std::vector<std::pair<Index, Index>> sorted_;  // (number, row); empty where consecutive_
  std::vector<std::pair<Index, Index>> repeats_;
  bool consecutive_ = false;  // number = base_ + row
  Index base_ = 0;
  Index rows_ = 0;
};

}  // namespace phymul
