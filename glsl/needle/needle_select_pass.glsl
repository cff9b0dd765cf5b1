// SPDX-License-Identifier: MIT
//
// The particles around the place of a node in the model's order, a row each: found down the levels of
// needle_around_pass.glsl, of which there are LEVELS. Drawn only; needs needle_state.glsl.

TABLE_INTS(around_who, around_who_place);
STORED(around_count_0, around_count_0_place);  // w: how many
STORED(around_count_1, around_count_1_place);
STORED(around_count_2, around_count_2_place);
STORED(around_count_3, around_count_3_place);
STORED(around_count_4, around_count_4_place);
STORED(around_count_5, around_count_5_place);

RESULT(0, int, particle_found);

int at, rest_of;  // row of a level; how many of its particles come before

#define DESCEND(table, place)                                          \
  at *= branch;                                                        \
  for (int k = 0; k < branch; ++k) {                                   \
    int here = int(fetch_changing(table, place, at).w);                \
    if (rest_of < here) break;                                         \
    rest_of -= here;                                                   \
    ++at;                                                              \
  }

void select_row(int row) {
  vec4 steps = state_row(1);
  if (int(steps.w) == done) discard;
  at = 0;
  rest_of = row;
#if LEVELS > 5
  DESCEND(around_count_4, around_count_4_place)
#endif
#if LEVELS > 4
  DESCEND(around_count_3, around_count_3_place)
#endif
#if LEVELS > 3
  DESCEND(around_count_2, around_count_2_place)
#endif
#if LEVELS > 2
  DESCEND(around_count_1, around_count_1_place)
#endif
#if LEVELS > 1
  DESCEND(around_count_0, around_count_0_place)
#endif
  int who = fetch_int(around_who, around_who_place, at);
  for (int k = 0; k < branch; ++k) {
    if (((who >> k) & 1) == 0) continue;
    if (rest_of == 0) {
      particle_found = branch * at + k;
      return;
    }
    --rest_of;
  }
  discard;
}

PASS_MAIN(select_row)
