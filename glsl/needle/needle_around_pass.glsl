// SPDX-License-Identifier: MIT
//
// The particles around the place of a node, 32 of the model to a row (FIRST), then 32 rows to one: who, how many, and
// their moments. Drawn only; needs needle_weights.glsl.

#ifndef FIRST
STORED(around_0, around_0_place);
STORED(around_1, around_1_place);
STORED(around_2, around_2_place);
#endif
uniform int source_count;

RESULT(0, vec4, moments_0);
RESULT(1, vec4, moments_1);  // w: how many
RESULT(2, vec4, moments_2);
#ifdef FIRST
RESULT(3, int, who);  // bit k: the k-th of them
#endif

void around_row(int row) {
  if (int(state_row(1).w) == done) discard;
  moments_0 = vec4(0.0);
  moments_1 = vec4(0.0);
  moments_2 = vec4(0.0);
  int first_row = branch * row;
  int end = min(first_row + branch, source_count);
#ifdef FIRST
  begin_needle();
  float inverse_reach = 1.0 / reach;
  who = 0;
  for (int i = first_row; i < end; ++i) {
    vec4 b = basis_at(i, aim, inverse_reach);
    float inside = inside_of(b);
    if (!(inside > 0.0)) continue;
    who |= 1 << (i - first_row);
    vec4 weighted = inside * inside * b;
    moments_0 += weighted;
    moments_1 += vec4(weighted.y * b.yzw, 1.0);
    moments_2 += vec4(weighted.z * b.z, weighted.z * b.w, weighted.w * b.w, 0.0);
  }
#else
  for (int source = first_row; source < end; ++source) {
    moments_0 += fetch_changing(around_0, around_0_place, source);
    moments_1 += fetch_changing(around_1, around_1_place, source);
    moments_2 += fetch_changing(around_2, around_2_place, source);
  }
#endif
}

PASS_MAIN(around_row)
