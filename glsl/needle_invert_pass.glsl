// SPDX-License-Identifier: MIT
//
// Two pivots of an inversion in place (Gauss and Jordan; a positive definite matrix needs no search for pivots), in sums
// of two floats. Nothing but zeros where a pivot is not positive. Drawn only, a row for each pair and one more; needs
// needle_state.glsl and two_floats.glsl.

STORED(needle_stiffness, needle_stiffness_place);
uniform int pivot;  // the first of the two

RESULT(0, vec2, entry);

bool positive;

vec2 entry_at(int i, int j) {
  return fetch_vec2(needle_stiffness, needle_stiffness_place, i * longest + j);
}

// What pivot p makes of the entry at i, j; of it and the pivot, and those of its row and column.
vec2 pivoted(bool in_row, bool in_column, vec2 own, vec2 of_column, vec2 of_row, vec2 at_pivot) {
  if (!(at_pivot.x > 0.0)) positive = false;
  if (in_row && in_column) return quotient_of(vec2(1.0, 0.0), at_pivot);
  if (in_row) return quotient_of(own, at_pivot);
  if (in_column) return -quotient_of(own, at_pivot);
  return sum_of(own, -product_of(of_column, quotient_of(of_row, at_pivot)));
}

vec2 after_first(int i, int j) {
  return pivoted(i == pivot, j == pivot, entry_at(i, j), entry_at(i, pivot), entry_at(pivot, j),
                 entry_at(pivot, pivot));
}

void invert_row(int row) {
  read_law();
  int i = row / longest;
  int j = row - i * longest;
  int held = int(fetch_vec2(needle_stiffness, needle_stiffness_place, longest * longest).x);
  entry = fetch_vec2(needle_stiffness, needle_stiffness_place, row);
  if (i >= held || j >= held || pivot >= held) return;
  positive = true;
  entry = after_first(i, j);
  int second = pivot + 1;
  if (second < held) {
    entry = pivoted(i == second, j == second, entry, after_first(i, second), after_first(second, j),
                    after_first(second, second));
  }
  if (!positive) entry = vec2(0.0);
}

PASS_MAIN(invert_row)
