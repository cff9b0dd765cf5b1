// SPDX-License-Identifier: MIT
#include "index_table.h"

#include <algorithm>

namespace phymul {

IndexTable::IndexTable(const std::vector<Index>& numbers) : rows_(static_cast<Index>(numbers.size())) {
  base_ = numbers.empty() ? 0 : numbers.front();
  consecutive_ = base_ >= 0;
  for (Index row = 0; row < rows_ && consecutive_; ++row) {
    consecutive_ = numbers[row] == std::int64_t{base_} + row;
  }
  if (consecutive_) return;
  sorted_.reserve(numbers.size());
  for (Index row = 0; row < rows_; ++row) {
    if (numbers[row] >= 0) sorted_.emplace_back(numbers[row], row);
  }
  std::sort(sorted_.begin(), sorted_.end());
  // The first of equal numbers stays: pairs are sorted by row too.
  const auto last = std::unique(sorted_.begin(), sorted_.end(), [this](const auto& kept, const auto& next) {
    if (kept.first != next.first) return false;
    repeats_.emplace_back(next.second, kept.second);
    return true;
  });
  sorted_.erase(last, sorted_.end());
  std::sort(repeats_.begin(), repeats_.end());
}

Index IndexTable::find(std::int64_t number) const {
  if (consecutive_) {
    return number >= base_ && number - base_ < rows_ ? static_cast<Index>(number - base_) : -1;
  }
  const auto found = std::lower_bound(sorted_.begin(), sorted_.end(), number,
                                      [](const auto& entry, std::int64_t wanted) { return entry.first < wanted; });
  return found != sorted_.end() && found->first == number ? found->second : -1;
}

std::vector<Index> IndexTable::find_range(std::int64_t first, std::int64_t last, std::int64_t& missing) const {
  std::vector<Index> rows;
  missing = -1;
  for (std::int64_t number = first; number <= last; ++number) {
    const Index row = find(number);
    if (row < 0) {
      missing = number;
      break;
    }
    rows.push_back(row);
  }
  return rows;
}

}  // namespace phymul
