// SPDX-License-Identifier: MIT
//
// Held nodes as needle_stiffness_pass.glsl chose them. Needs needle_held.glsl and needle_pairs.glsl.

void read_held() {
  held_count = held_nodes();
  if (held_count > 0 && !(pair_at(0, 0).x > 0.0)) held_count = 0;  // there was no inverse
  for (int row = 0; row < held_count; ++row) {
    vec2 one = pair_at(longest, row);
    held_node[row] = int(one.x);
    held_arm[row] = one.y;
  }
}
