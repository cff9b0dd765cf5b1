// SPDX-License-Identifier: MIT
#include "box_tree.h"

#include <algorithm>

namespace phymul::cpu {

BoxTree::BoxTree(const VecList& places, const std::vector<Index>& group, Index count) {
  std::vector<std::vector<Index>> own(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < places.size(); ++k) own[group[k]].push_back(static_cast<Index>(k));
  groups.push_back(0);
  for (const std::vector<Index>& rows : own) {
    const auto first = static_cast<Index>(items.size());
    items.insert(items.end(), rows.begin(), rows.end());
    if (!rows.empty()) add(places, first, static_cast<Index>(items.size()));
    groups.push_back(static_cast<Index>(nodes.size()));
  }
}

void BoxTree::add(const VecList& places, Index first, Index end) {
  const std::size_t own = nodes.size();
  nodes.push_back({first, end, 0, end - first <= leaf_size});
  if (!nodes[own].is_leaf) {
    Vec3 low = places[items[first]], high = low;
    for (Index k = first + 1; k < end; ++k) {
      low = low.cwiseMin(places[items[k]]);
      high = high.cwiseMax(places[items[k]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const Index middle = first + (end - first) / 2;
    std::nth_element(items.begin() + first, items.begin() + middle, items.begin() + end, [&](Index a, Index b) {
      return places[a][axis] != places[b][axis] ? places[a][axis] < places[b][axis] : a < b;
    });
    add(places, first, middle);
    add(places, middle, end);
  }
  nodes[own].next = static_cast<Index>(nodes.size());
}

}  // namespace phymul::cpu
