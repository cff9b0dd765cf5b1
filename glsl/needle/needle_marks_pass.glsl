// SPDX-License-Identifier: MIT
//
// Per particle, bit k: it is one of node k's. Drawn only; needs needle_state.glsl.

uniform int all_new;  // 1: of all nodes, whatever the step has made

RESULT(0, ivec2, mark);

void marks_row(int i) {
  read_law();
  read_header();
  if (all_new == 0 && known == node_count) discard;
  mark = ivec2(0);
  for (int k = 0; k < node_count; ++k) {
    if (entry_of(k, i) < 0) continue;
    if (k < 32) {
      mark.x |= 1 << k;
    } else {
      mark.y |= 1 << (k - 32);
    }
  }
}

PASS_MAIN(marks_row)
