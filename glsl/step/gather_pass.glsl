// SPDX-License-Identifier: MIT
//
// What the host asks of particles in an open step, a row for each of its list. Needs tables.glsl and pushed_tables.glsl.

TABLE_INTS(gather_rows, gather_rows_place);  // of the particle

RESULT(0, vec4, gathered_displacement);  // m, at the step's start
RESULT(1, vec4, gathered_velocity);      // m/s: it would go to x + dt v
RESULT(2, vec4, gathered_withheld);      // N

void gather_row(int row) {
  int i = fetch_load_ivec4(gather_rows, gather_rows_place, row).x;
  gathered_displacement = fetch_changing(displacement, displacement_place, i);
  gathered_velocity = fetch_load_vec4(free_velocity, free_velocity_place, i);
  gathered_withheld = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
}

PASS_MAIN(gather_row)
