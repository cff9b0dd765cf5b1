// SPDX-License-Identifier: MIT
//
// The end of a step of all particles, a lane each, over what step_pass.glsl left. Needs kept_step_pass.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, next_pair, number;

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
  free_displacement_place = pair_place(next_pair);
  free_velocity_place = free_displacement_place + place_count;
  free_acceleration_place = measured_place;
  batch_step = number;
  kept_step_row(i);
  changing_rows[free_displacement_place + i] = floatBitsToInt(next_displacement);
  changing_rows[free_velocity_place + i] = floatBitsToInt(next_velocity);
  changing_rows[measured_place + i] = floatBitsToInt(next_measured);
}
