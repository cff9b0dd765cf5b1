// SPDX-License-Identifier: MIT
//
// Per particle, what the rounds of a tool come to, as pushed_tables.glsl reads it. Needs surface_tables.glsl,
// pushed_tables.glsl and touch_tools.glsl.

RESULT(0, vec4, force_after);
RESULT(1, vec4, velocity_after);
RESULT(2, vec4, shift_after);
RESULT(3, vec4, given_by_tool);  // N s; 1 where it touched

void end_row(int i) {
  force_after = fetch_load_vec4(pushed_force, pushed_force_place, i);
  velocity_after = fetch_load_vec4(free_velocity, free_velocity_place, i);
  shift_after = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
  given_by_tool = vec4(0.0);
  ivec4 around = fetch_load_ivec4(patch_ranges, patch_ranges_place, i);
  if (around.x == around.y) return;
  vec3 given = fetch_load_vec4(corner_given, corner_given_place, i).xyz;
  force_after = vec4(force_after.xyz + inverse_dt * given, force_after.w);
  velocity_after = vec4(velocity_after.xyz + shift_after.w * given, velocity_after.w);
  shift_after = vec4(shift_after.xyz + fetch_load_vec4(corner_shift, corner_shift_place, i).xyz, shift_after.w);
  given_by_tool = vec4(given, given == vec3(0.0) ? 0.0 : 1.0);
}

PASS_MAIN(end_row)
