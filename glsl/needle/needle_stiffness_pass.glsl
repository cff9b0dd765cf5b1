// SPDX-License-Identifier: MIT
//
// How the nodes that a bending shaft holds give way under impulses on each, in sums of two floats; behind the pairs which
// nodes those are, and their distances from the hub. Drawn only, a row for each pair and each node; needs
// needle_held.glsl.

RESULT(0, vec2, entry);

void stiffness_row(int row) {
  begin_needle();
  begin_motion();
  for (int k = 0; k < node_count; ++k) {
    node_place[k] = fetch_changing(needle_places, needle_places_place, k);
    node_motion[k].w = coupling(k, k).w;
  }
  choose_held(0);
  int i = row / longest;
  int j = row - i * longest;
  entry = vec2(0.0);
  if (i >= longest) {
    entry = j < held_count ? vec2(float(held_node[j]), held_arm[j]) : vec2(-1.0, 0.0);
  } else if (i < held_count && j < held_count) {
    entry = gives(max(i, j), min(i, j));
  }
}

PASS_MAIN(stiffness_row)
