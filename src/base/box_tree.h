// SPDX-License-Identifier: MIT
//
// Trees over what lies somewhere, one a group, halved along the longest side of its box: boxes of leaves on a surface
// are small, where a curve through space would jump. Built once, from places at rest; boxes move, trees do not.
#pragma once

#include <phymul/types.h>

#include <vector>

namespace phymul::cpu {

struct BoxTree {
  struct Node {
    Index first = 0, end = 0;  ///< items in it
    Index next = 0;            ///< the node behind its last descendant; a leaf's is the one behind it
    bool is_leaf = false;      ///< at most `leaf_size` items
  };
  static constexpr Index leaf_size = 8;

  BoxTree() = default;
  /// `group`, 0 ... groups - 1, of each place.
  BoxTree(const VecList& places, const std::vector<Index>& group, Index groups);

  std::vector<Node> nodes;    ///< each tree in preorder: a node's first child stands behind it
  std::vector<Index> items;   ///< rows of `places`
  std::vector<Index> groups;  ///< [groups + 1] first node of each; equal where a group has no items

 private:
  void add(const VecList& places, Index first, Index end);
};

}  // namespace phymul::cpu
