// SPDX-License-Identifier: MIT
//
// Of an inversion in place, PANEL pivots (needle_invert_pass.glsl): their rows as they become, in sums of two floats.
// Nothing but zeros where a pivot is not positive. Drawn only, a row for each entry; needs needle_pairs.glsl and
// two_floats.glsl.

uniform int pivot;  // the first of them

RESULT(0, vec2, entry);

vec2 block[PANEL * PANEL];

// In place, by Gauss and Jordan: a positive definite matrix needs no search for pivots.
bool invert_block(int size) {
  for (int p = 0; p < size; ++p) {
    vec2 at_pivot = block[PANEL * p + p];
    if (!(at_pivot.x > 0.0)) return false;
    vec2 inverse = quotient_of(vec2(1.0, 0.0), at_pivot);
    for (int j = 0; j < size; ++j) {
      if (j != p) block[PANEL * p + j] = product_of(block[PANEL * p + j], inverse);
    }
    for (int i = 0; i < size; ++i) {
      if (i == p) continue;
      vec2 factor = block[PANEL * i + p];
      for (int j = 0; j < size; ++j) {
        if (j == p) continue;
        block[PANEL * i + j] = sum_of(block[PANEL * i + j], -product_of(factor, block[PANEL * p + j]));
      }
      block[PANEL * i + p] = -product_of(factor, inverse);
    }
    block[PANEL * p + p] = inverse;
  }
  return true;
}

void panel_row(int row) {
  read_law();
  int p = row / longest;
  int j = row - p * longest;
  int held = held_nodes();
  int size = min(PANEL, held - pivot);
  entry = vec2(0.0);
  if (p >= size || j >= held) return;
  for (int a = 0; a < size; ++a) {
    for (int b = 0; b < size; ++b) block[PANEL * a + b] = pair_at(pivot + a, pivot + b);
  }
  if (!invert_block(size)) return;
  if (j >= pivot && j < pivot + size) {
    entry = block[PANEL * p + j - pivot];
    return;
  }
  for (int q = 0; q < size; ++q) entry = sum_of(entry, product_of(block[PANEL * p + q], pair_at(pivot + q, j)));
}

PASS_MAIN(panel_row)
