// SPDX-License-Identifier: MIT
//
// A step of one particle, computed and stored. Dispatched only; needs step_pass.glsl and, where KEPT_VOLUMES is defined,
// kept_along_pass.glsl.

uniform int gravity_place;  // of the loads: a row per instant

int next_pair_place;

// Reads pair `from`, writes pair `to`.
void begin_step(int from, int to, int number) {
  displacement_place = pair_place(from);
  velocity_place = displacement_place + place_count;
  next_pair_place = pair_place(to);
  batch_step = number;
  instant = number - 1;
  gravity = fetch_load_vec4(gravity, gravity_place, instant).xyz;
}

void store_step(int i, bool measuring) {
#ifdef TOOLS
  telling_last = measuring;
#endif
  step_row(i);
  changing_rows[next_pair_place + i] = floatBitsToInt(next_displacement);
  changing_rows[next_pair_place + place_count + i] = floatBitsToInt(next_velocity);
#ifdef KEPT_VOLUMES  // measured is what ends the step
  changing_rows[measured_place + i] = floatBitsToInt(next_measured);
  along_row(i);
  load_rows[kept_along_place + i] = floatBitsToInt(kept_direction);
#else
  if (measuring) changing_rows[measured_place + i] = floatBitsToInt(next_measured);
#endif
}
