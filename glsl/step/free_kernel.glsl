// SPDX-License-Identifier: MIT
//
// Where each particle would go, a lane each. Needs free_pass.glsl and pushed_tables.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, number, measuring;
uniform int gravity_place;

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
  instant = number - 1;
  gravity = fetch_load_vec4(gravity, gravity_place, instant).xyz;
#ifdef TOOLS
  batch_step = number;
  telling_last = measuring != 0;
#endif
  free_row(i);
  load_rows[pushed_force_place + i] = floatBitsToInt(force_sum);
  load_rows[free_velocity_place + i] = floatBitsToInt(velocity_before);
#ifdef HOST_STEP
  load_rows[pushed_shift_place + i] = floatBitsToInt(withheld_before);
  changing_rows[measured_place + i] = floatBitsToInt(speed_before);
#else
  load_rows[pushed_shift_place + i] = floatBitsToInt(shift_before);
#endif
}
