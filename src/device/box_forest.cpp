// SPDX-License-Identifier: MIT
#include "box_forest.h"

#include <algorithm>

#include "topology/locality_order.h"

namespace phymul {
namespace {

/// Adds a node over entries first ... end - 1 and those below it. Returns its level.
Index add_node(std::vector<Int4>& nodes, Index first, Index end) {
  const std::size_t own = nodes.size();
  nodes.push_back({first, end, 0, 1});
  Index level = 1;
  if (end - first > BoxForest::items_a_leaf) {
    Index share = BoxForest::items_a_leaf;  // of a child: all but the last are full
    while (share * BoxForest::children < end - first) share *= BoxForest::children;
    for (Index at = first; at < end; at += share) {
      level = std::max(level, 1 + add_node(nodes, at, std::min(at + share, end)));
    }
  }
  nodes[own][2] = static_cast<std::int32_t>(nodes.size());
  nodes[own][3] = level;
  return level;
}

}  // namespace

BoxForest::BoxForest(const VecList& places, const std::vector<Index>& group, Index groups) {
  const std::vector<Index> along = locality_order(places, std::vector<Index>(places.size(), 0), 1);
  std::vector<std::vector<std::int32_t>> of_group(static_cast<std::size_t>(groups));
  for (const Index row : along) of_group[static_cast<std::size_t>(group[row])].push_back(row);
  for (const std::vector<std::int32_t>& own : of_group) {
    const auto first = static_cast<Index>(items.size());
    items.insert(items.end(), own.begin(), own.end());
    const auto root = static_cast<std::int32_t>(nodes.size());
    if (!own.empty()) levels = std::max(levels, add_node(nodes, first, static_cast<Index>(items.size())));
    roots.push_back({root, static_cast<std::int32_t>(nodes.size())});
  }
}

}  // namespace phymul
