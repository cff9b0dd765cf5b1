// SPDX-License-Identifier: MIT
//
// The end of a step of one particle, computed and stored over what step_pass.glsl left. Dispatched only; needs
// kept_step_pass.glsl.

void begin_kept_step(int from, int to, int number) {
  displacement_place = pair_place(from);
  velocity_place = displacement_place + place_count;
  free_displacement_place = pair_place(to);
  free_velocity_place = free_displacement_place + place_count;
  free_acceleration_place = measured_place;
  batch_step = number;
}

void store_kept_step(int i) {
  kept_step_row(i);
  changing_rows[free_displacement_place + i] = floatBitsToInt(next_displacement);
  changing_rows[free_velocity_place + i] = floatBitsToInt(next_velocity);
  changing_rows[measured_place + i] = floatBitsToInt(next_measured);
}
