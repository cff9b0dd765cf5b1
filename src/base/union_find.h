// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace phymul {

/// Sets of the numbers below `count`, each alone at first.
class UnionFind {
 public:
  explicit UnionFind(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  Index root(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Whether they were apart. The smaller root stays.
  bool join(Index a, Index b) {
    if (parent_[a] == parent_[b]) return false;
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace phymul
