// SPDX-License-Identifier: MIT
//
// Trees over places, one a group, halved along the longest side of their box: boxes of leaves on a surface are small,
// where a curve through space would jump. Walked without a stack. Built once, from places at rest; boxes are the
// user's, and may move.
#pragma once

#include <phymul/types.h>

#include <utility>
#include <vector>

namespace phymul {

struct BoxTree {
  struct Node {
    Index first = 0, end = 0;  ///< items in it
    Index next = 0;            ///< the node behind its last descendant; a leaf's is the one behind it
    bool is_leaf = false;      ///< at most `leaf_size` items
  };
  struct Shape {
    Index leaf_size = 8;
    int halvings = 1;  ///< of a node into its children, of which there are two to the power of this at most
  };

  BoxTree() = default;
  /// `group`, 0 ... count - 1, of each place.
  BoxTree(const VecList& places, const std::vector<Index>& group, Index count) : BoxTree(places, group, count, {}) {}
  BoxTree(const VecList& places, const std::vector<Index>& group, Index count, const Shape& shape);

  std::vector<Node> nodes;    ///< each tree in preorder: a node's first child stands behind it
  std::vector<Index> items;   ///< rows of `places`
  std::vector<Index> groups;  ///< [groups + 1] first node of each; equal where a group has no items

 private:
  void add(const VecList& places, const Shape& shape, Index first, Index end);
  void halve(const VecList& places, const Shape& shape, Index first, Index end, int halvings);

  std::vector<std::pair<double, Index>> keys_;  // of the node at hand: what places are compared by, beside each other
};

}  // namespace phymul
