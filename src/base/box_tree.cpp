// SPDX-License-Identifier: MIT
#include "box_tree.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace phymul {

BoxTree::BoxTree(const VecList& places, const std::vector<Index>& group, Index count, const Shape& shape) {
  std::vector<std::vector<Index>> own(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < places.size(); ++k) own[group[k]].push_back(static_cast<Index>(k));
  groups.push_back(0);
  for (const std::vector<Index>& rows : own) {
    const auto first = static_cast<Index>(items.size());
    items.insert(items.end(), rows.begin(), rows.end());
    if (!rows.empty()) add(places, shape, first, static_cast<Index>(items.size()));
    groups.push_back(static_cast<Index>(nodes.size()));
  }
  keys_ = {};
}

void BoxTree::add(const VecList& places, const Shape& shape, Index first, Index end) {
  const std::size_t own = nodes.size();
  nodes.push_back({first, end, 0, end - first <= shape.leaf_size});
  if (!nodes[own].is_leaf) halve(places, shape, first, end, shape.halvings);
  nodes[own].next = static_cast<Index>(nodes.size());
}

/// Adds nodes for the parts, which are more than a leaf until they have been halved often enough.
void BoxTree::halve(const VecList& places, const Shape& shape, Index first, Index end, int halvings) {
  if (halvings == 0 || end - first <= shape.leaf_size) return add(places, shape, first, end);
  Eigen::AlignedBox3d box;
  for (Index k = first; k < end; ++k) box.extend(places[items[k]]);
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const Index middle = first + (end - first) / 2;
  keys_.clear();
  for (Index k = first; k < end; ++k) keys_.emplace_back(places[items[k]][axis], items[k]);
  std::ranges::nth_element(keys_, keys_.begin() + (middle - first));
  for (Index k = first; k < end; ++k) items[k] = keys_[k - first].second;
  halve(places, shape, first, middle, halvings - 1);
  halve(places, shape, middle, end, halvings - 1);
}

}  // namespace phymul
