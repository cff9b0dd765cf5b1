// SPDX-License-Identifier: MIT
//
// Before the first phase of a step: no impulse yet, and everybody waits for the first of its contacts. What a batch has
// to tell is taken on from the step before. Needs contact_lists.glsl and contact_sweeps.glsl.

uniform int batch_step;  // counts from 1

RESULT(0, vec4, pressing_now);
RESULT(1, vec4, pushing_now);
RESULT(2, ivec4, turns_now);

void start_row(int row) {
  pressing_now = vec4(0.0);
  pushing_now = vec4(0.0);
  turns_now = ivec4(0);
  if (row >= surface_count) return;
  pressing_now = fetch_changing(surface_velocity, surface_velocity_place, row);
  int first = takes_pushes(row) ? entry_after(-1, row) : unmoved;
  turns_now = ivec4(first, 0, max(first, done_with), 0);
  if (batch_step == 1) return;
  ivec4 before = fetch_ivec4(turns, turns_place, row);
  turns_now.w = before.w == 0 && before.x >= 0 ? batch_step - 1 : before.w;
  pushing_now.w = fetch_changing(pushing, pushing_place, row).w;
}

PASS_MAIN(start_row)
