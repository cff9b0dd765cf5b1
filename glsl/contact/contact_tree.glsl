// SPDX-License-Identifier: MIT
//
// Trees of boxes (src/base/box_tree.h), walked without a stack: whose box is of interest is entered, else skipped. Needs
// dialect_fragment.glsl.

TABLE_INTS(tree_nodes, tree_nodes_place);  // first and end item, the node to go to when this one is skipped, level from 1
TABLE_INTS(tree_items, tree_items_place);
STORED(tree_low, tree_low_place);    // of what is in it, m; least surface row where contacts are
STORED(tree_high, tree_high_place);  // likewise; the largest

uniform int tree_size;  // nodes

ivec4 tree_node(int n) {
  return fetch_ivec4(tree_nodes, tree_nodes_place, n);
}

int tree_item(int entry) {
  return fetch_int(tree_items, tree_items_place, entry);
}
