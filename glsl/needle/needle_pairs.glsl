// SPDX-License-Identifier: MIT
//
// Pairs of held nodes in sums of two floats, and who they are: needle_stiffness_pass.glsl. Needs needle_state.glsl.

STORED(needle_stiffness, needle_stiffness_place);

vec2 pair_at(int i, int j) {
  return fetch_vec2(needle_stiffness, needle_stiffness_place, i * longest + j);
}

int held_nodes() {
  int count = 0;
  while (count < longest && pair_at(longest, count).x >= 0.0) ++count;
  return count;
}
