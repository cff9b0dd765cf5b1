// SPDX-License-Identifier: MIT
//
// BoxForest: trees over what lies somewhere, one a group, for devices that give each node the box of what is in it and
// walk the trees without a stack. Built once, from places at rest; boxes move, trees do not.
#pragma once

#include <vector>

#include "float_tables.h"

namespace phymul {

struct BoxForest {
  static constexpr Index items_a_leaf = 2, children = 8;

  /// `group`, 0 ... groups - 1, of each place.
  BoxForest(const VecList& places, const std::vector<Index>& group, Index groups);

  /// First and end entry of `items` in it; the node behind its last descendant; level, 1 for leaves and more than that
  /// of its children. Each tree in preorder: a node's first child stands behind it.
  std::vector<Int4> nodes;
  std::vector<std::int32_t> items;  ///< rows of `places`
  std::vector<Int2> roots;          ///< [groups] first node and end of its nodes; equal where the group has no items
  Index levels = 0;
};

}  // namespace phymul
