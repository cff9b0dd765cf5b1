// SPDX-License-Identifier: MIT
//
// Per particle, what the rounds of a tool come to, and what it does to particles below the surface, as
// pushed_tables.glsl reads it. Needs surface_tables.glsl, pushed_tables.glsl and touch_tools.glsl.

RESULT(0, vec4, force_after);
RESULT(1, vec4, velocity_after);
RESULT(2, vec4, shift_after);
RESULT(3, vec4, given_by_tool);  // N s; 1 where it touched

// As with ToolContact::particles, unless it was deep in the tool before: is_deep_in of surface_press.h.
void stop_below_surface(int i) {
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  if (held.w >= 0.0) return;
  TouchedParticle p = untouched(i, displaced(i), velocity_after.xyz, int(velocity_after.w));
  ShapeIn shape = tool_shape(acting_tool);
  vec3 start = inside(tool_frame(acting_tool, instant), place_from(tool_frame(acting_tool, instant), p, p.u));
  if (distance_to(shape, start).phi < -0.01 * shape.thickness) return;
  Reaction reaction = touch_tool(acting_tool, held, instant, p, dt, inverse_dt);
  force_after = vec4(force_after.xyz + inverse_dt * p.impulse, force_after.w);
  velocity_after = vec4(p.v, velocity_after.w);
  shift_after = vec4(shift_after.xyz + p.shift, shift_after.w);
  given_by_tool = vec4(p.impulse, reaction.touches ? 1.0 : 0.0);
}

void end_row(int i) {
  force_after = fetch_load_vec4(pushed_force, pushed_force_place, i);
  velocity_after = fetch_load_vec4(free_velocity, free_velocity_place, i);
  shift_after = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
  given_by_tool = vec4(0.0);
  ivec4 around = fetch_load_ivec4(patch_ranges, patch_ranges_place, i);
  if (around.x == around.y) {
    stop_below_surface(i);
    return;
  }
  vec3 given = fetch_load_vec4(corner_given, corner_given_place, i).xyz;
  force_after = vec4(force_after.xyz + inverse_dt * given, force_after.w);
  velocity_after = vec4(velocity_after.xyz + shift_after.w * given, velocity_after.w);
  shift_after = vec4(shift_after.xyz + fetch_load_vec4(corner_shift, corner_shift_place, i).xyz, shift_after.w);
  given_by_tool = vec4(given, given == vec3(0.0) ? 0.0 : 1.0);
}

PASS_MAIN(end_row)
