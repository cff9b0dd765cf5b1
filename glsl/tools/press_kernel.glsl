// SPDX-License-Identifier: MIT
//
// Where needles act or tools touch surfaces, what presses does so after what holds: tools that are no needles, on
// particles that none holds, a lane each. Dispatched only; needs free_step.glsl, pushed_tables.glsl and tell_tools.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, number, measuring;
uniform int first_tool, end_tool;
OF_STEP(int, batch_step);  // counts from 1

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  if (held.w >= 0.0) return;  // free_kernel.glsl told of it
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
  batch_step = number;
  instant = number - 1;
  telling_last = measuring != 0;
  vec4 v = fetch_load_vec4(free_velocity, free_velocity_place, i);
  vec4 force = fetch_load_vec4(pushed_force, pushed_force_place, i);
  if (force.w > 0.0) cut_elastic_force(i);  // for what it withholds
  TouchedParticle touched = untouched(i, displaced(i), v.xyz, fixed_axes(i));
  for (int tool = first_tool; tool < end_tool; ++tool) {
    if (is_needle(tool)) continue;
    Reaction reaction = touch_tool(tool, held, instant, touched, dt, inverse_dt);
    TELL_TOOL(tool, i, reaction);
  }
  vec4 shift = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
  load_rows[pushed_force_place + i] = floatBitsToInt(vec4(force.xyz + inverse_dt * touched.impulse, force.w));
  load_rows[free_velocity_place + i] = floatBitsToInt(vec4(touched.v, v.w));
  load_rows[pushed_shift_place + i] = floatBitsToInt(vec4(shift.xyz + touched.shift, shift.w));
}
