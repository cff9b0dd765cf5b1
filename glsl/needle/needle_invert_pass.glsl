// SPDX-License-Identifier: MIT
//
// PANEL pivots of an inversion in place, in sums of two floats: what they make of all entries. Drawn only, a row for each
// pair and each node; needs needle_pairs.glsl and two_floats.glsl.

STORED(needle_panel, needle_panel_place);  // needle_panel_pass.glsl
uniform int pivot;

RESULT(0, vec2, entry);

vec2 panel_at(int p, int j) {
  return fetch_vec2(needle_panel, needle_panel_place, p * longest + j);
}

void invert_row(int row) {
  read_law();
  int i = row / longest;
  int j = row - i * longest;
  entry = pair_at(i, j);
  if (i >= longest) return;
  int held = held_nodes();
  if (i >= held || j >= held || pivot >= held) return;
  int end = min(pivot + PANEL, held);
  if (!(panel_at(0, pivot).x > 0.0)) {
    entry = vec2(0.0);
  } else if (i >= pivot && i < end) {
    entry = panel_at(i - pivot, j);
  } else {
    if (j >= pivot && j < end) entry = vec2(0.0);
    for (int p = pivot; p < end; ++p) entry = sum_of(entry, -product_of(pair_at(i, p), panel_at(p - pivot, j)));
  }
}

PASS_MAIN(invert_row)
