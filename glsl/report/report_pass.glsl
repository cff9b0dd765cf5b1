// SPDX-License-Identifier: MIT
//
// ROWS_TO_ONE rows to one, until one row is left. FIRST reads what step_pass.glsl wrote, later passes their own results.
// Drawn only; needs tables.glsl and report_events.glsl.

uniform int source_count;
#ifndef FIRST
TABLE_INTS(events, events_place);
STORED(maxima, maxima_place);
#endif

RESULT(0, ivec4, least_events);
RESULT(1, vec4, largest);

void report_row(int row) {
  ivec4 found = ivec4(never, never, never, 0);
  vec4 most = vec4(0.0);
  int end = min(ROWS_TO_ONE * (row + 1), source_count);
  for (int source = ROWS_TO_ONE * row; source < end; ++source) {
#ifdef FIRST
    vec4 u = fetch_changing(displacement, displacement_place, source);
    merge_events(found, events_of(u, fetch_changing(velocity, velocity_place, source), source));
    merge_largest(most, fetch_changing(measured, measured_place, source));
#else
    merge_events(found, fetch_ivec4(events, events_place, source));
    merge_largest(most, fetch_changing(maxima, maxima_place, source));
#endif
  }
  least_events = found;
  largest = most;
}

PASS_MAIN(report_row)
