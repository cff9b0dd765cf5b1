// SPDX-License-Identifier: MIT
//
// Per particle, what one tool with ToolContact::particles does to it in a scene that has other tools, in their order:
// press_kernel.glsl, drawn. Needs surface_tables.glsl, pushed_tables.glsl and touch_tools.glsl.

RESULT(0, vec4, force_after);
RESULT(1, vec4, velocity_after);
RESULT(2, vec4, shift_after);
RESULT(3, vec4, given_by_tool);  // N s; 1 where it touched

void press_row(int i) {
  force_after = fetch_load_vec4(pushed_force, pushed_force_place, i);
  velocity_after = fetch_load_vec4(free_velocity, free_velocity_place, i);
  shift_after = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
  given_by_tool = vec4(0.0);
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  if (held.w >= 0.0) return;  // free_pass.glsl saw to it
  TouchedParticle touched = untouched(i, displaced(i), velocity_after.xyz, int(velocity_after.w));
  Reaction reaction = touch_tool(acting_tool, held, instant, touched, dt, inverse_dt);
  force_after = vec4(force_after.xyz + inverse_dt * touched.impulse, force_after.w);
  velocity_after = vec4(touched.v, velocity_after.w);
  shift_after = vec4(shift_after.xyz + touched.shift, shift_after.w);
  given_by_tool = vec4(touched.impulse, reaction.touches ? 1.0 : 0.0);
}

PASS_MAIN(press_row)
