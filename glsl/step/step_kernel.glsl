// SPDX-License-Identifier: MIT
//
// One step of all particles, a lane each, from a pair of displacements and velocities to another. Needs step_pass.glsl
// and, where KEPT_VOLUMES is defined, kept_along_pass.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, next_pair, number, measuring;
uniform int gravity_place;  // of the loads: a row per instant

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
  int next_pair_place = pair_place(next_pair);
  batch_step = number;
  instant = number - 1;
  gravity = fetch_load_vec4(gravity, gravity_place, instant).xyz;
#ifdef TOOLS
  telling_last = measuring != 0;
#endif
  step_row(i);
  changing_rows[next_pair_place + i] = floatBitsToInt(next_displacement);
  changing_rows[next_pair_place + place_count + i] = floatBitsToInt(next_velocity);
#ifdef KEPT_VOLUMES  // measured is what ends the step
  changing_rows[measured_place + i] = floatBitsToInt(next_measured);
  along_row(i);
  load_rows[kept_along_place + i] = floatBitsToInt(kept_direction);
#else
  if (measuring != 0) changing_rows[measured_place + i] = floatBitsToInt(next_measured);
#endif
}
