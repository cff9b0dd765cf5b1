// SPDX-License-Identifier: MIT
//
// ROWS_TO_ONE rows to one, until one is left, of what a batch's steps tell of their phases: the first step that was not
// done (0: none), most phases that a step took. FIRST reads what the last phase left, later passes their own results.
// Needs contact_sweeps.glsl.

uniform int source_count;
uniform int last_step;  // of the batch
#ifndef FIRST
STORED(told, told_place);
#endif

RESULT(0, vec4, phases_told);

void told_row(int row) {
  float unfinished = 0.0;
  float most = 0.0;
  int end = min(ROWS_TO_ONE * (row + 1), source_count);
  for (int source = ROWS_TO_ONE * row; source < end; ++source) {
#ifdef FIRST
    ivec4 turn = fetch_ivec4(turns, turns_place, source);
    float step = float(turn.w == 0 && turn.x >= 0 ? last_step : turn.w);
    float phases = fetch_changing(pushing, pushing_place, source).w;
#else
    float step = fetch_changing(told, told_place, source).x;
    float phases = fetch_changing(told, told_place, source).y;
#endif
    if (step > 0.0 && (unfinished == 0.0 || step < unfinished)) unfinished = step;
    most = max(most, phases);
  }
  phases_told = vec4(unfinished, most, 0.0, 0.0);
}

PASS_MAIN(told_row)
