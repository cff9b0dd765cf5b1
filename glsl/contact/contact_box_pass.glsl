// SPDX-License-Identifier: MIT
//
// Boxes of one level of trees, from what is in them or from the level before; the other levels' as they are. Of triangles,
// or where MEETINGS is defined of the corners of the triangles that particles are in contact with, and beside them the
// least and the largest of those particles. Needs contact_surfaces.glsl and contact_tree.glsl.

uniform int tree_level;

const float nowhere = 3e38;

RESULT(0, vec4, box_low);
RESULT(1, vec4, box_high);

// What is not a number is in no box: it is found out elsewhere.
void take_in(vec4 low, vec4 high) {
  box_low = mix(box_low, low, lessThan(low, box_low));
  box_high = mix(box_high, high, lessThan(box_high, high));
}

void take_in_corners(ivec4 corners, float mark) {
  vec4 a = vec4(about_place(corners.x), mark);
  vec4 b = vec4(about_place(corners.y), mark);
  vec4 c = vec4(about_place(corners.z), mark);
  take_in(a, a);
  take_in(b, b);
  take_in(c, c);
}

void take_in_item(int item) {
#ifdef MEETINGS
  for (int m = item * body_count; m < (item + 1) * body_count; ++m) {
    ivec4 who = who_meet(m);
    if (who.x >= 0) take_in_corners(who.yzwx, float(item));
  }
#else
  take_in_corners(fetch_ivec4(triangle, triangle_place, item), 0.0);
#endif
}

void node_row(int n) {
  ivec4 node = tree_node(n);
  box_low = vec4(nowhere);
  box_high = vec4(-nowhere);
  if (node.w != tree_level) {
    if (node.w > tree_level) return;
    box_low = fetch_changing(tree_low, tree_low_place, n);
    box_high = fetch_changing(tree_high, tree_high_place, n);
  } else if (node.w == 1) {
    for (int entry = node.x; entry < node.y; ++entry) take_in_item(tree_item(entry));
  } else {
    for (int child = n + 1; child < node.z; child = tree_node(child).z) {
      take_in(fetch_changing(tree_low, tree_low_place, child), fetch_changing(tree_high, tree_high_place, child));
    }
  }
}

PASS_MAIN(node_row)
