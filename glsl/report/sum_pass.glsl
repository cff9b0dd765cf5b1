// SPDX-License-Identifier: MIT
//
// ROWS_TO_ONE rows to one, added. Drawn only; needs dialect_fragment.glsl.

STORED(terms, terms_place);
uniform int source_count;

RESULT(0, vec4, total);

void sum_row(int row) {
  vec4 sum = vec4(0.0);
  int end = min(ROWS_TO_ONE * (row + 1), source_count);
  for (int source = ROWS_TO_ONE * row; source < end; ++source) sum = sum + fetch_changing(terms, terms_place, source);
  total = sum;
}

PASS_MAIN(sum_row)
