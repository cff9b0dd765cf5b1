// SPDX-License-Identifier: MIT
//
// How an impulse on one node moves another: a sum over their common particles, 1/kg along the axes, and of one number for
// all of them. Drawn only, a row for each pair; needs needle_weights.glsl.

uniform int all_new;

RESULT(0, vec4, coupling_row);

void pair_row(int row) {
  read_law();
  read_header();
  int k = row / longest;
  int other = row - k * longest;
  int later = max(k, other);
  if (later >= node_count || (all_new == 0 && later < known)) discard;
  int earlier = min(k, other);
  int ends = around(earlier);
  int later_ends = around(later);
  coupling_row = vec4(0.0);
  int at = 0;
  ivec2 theirs = list_entry(later, 0);
  for (int j = 0; j < ends; ++j) {
    ivec2 own = list_entry(earlier, j);
    while (theirs.x < own.x && at + 1 < later_ends) {
      ++at;
      theirs = list_entry(later, at);
    }
    if (theirs.x != own.x) continue;
    coupling_row += intBitsToFloat(own.y) * eased(own.x, intBitsToFloat(theirs.y));
  }
}

PASS_MAIN(pair_row)
