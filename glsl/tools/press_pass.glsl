// SPDX-License-Identifier: MIT
//
// Per particle, what presses after needles: tools that are none, on what none holds. Twin of press_kernel.glsl, drawn.
// Needs free_step.glsl, touch_tools.glsl and pushed_tables.glsl.

RESULT(0, vec4, force_row);
RESULT(1, vec4, velocity_row);
RESULT(2, vec4, shift_row);

void press_row(int i) {
  force_row = fetch_load_vec4(pushed_force, pushed_force_place, i);
  velocity_row = fetch_load_vec4(free_velocity, free_velocity_place, i);
  shift_row = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  if (held.w >= 0.0) return;
  TouchedParticle touched = untouched(i, displaced(i), velocity_row.xyz, fixed_axes(i));
  for (int tool = 0; tool < tool_count; ++tool) {
    if (is_needle(tool)) continue;
    touch_tool(tool, held, instant, touched, dt, inverse_dt);
  }
  force_row.xyz = force_row.xyz + inverse_dt * touched.impulse;
  velocity_row.xyz = touched.v;
  shift_row.xyz = touched.shift;
}

PASS_MAIN(press_row)
