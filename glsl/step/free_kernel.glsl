// SPDX-License-Identifier: MIT
//
// Where each particle would go by itself and by the tools that touch it (where HOLDS_ONLY is defined: that hold it), a lane
// each; nothing moves yet. Dispatched only; needs free_step.glsl and pushed_tables.glsl, and tell_tools.glsl where TOOLS
// is defined.

layout(local_size_x = GROUP) in;

uniform int pair, number, measuring;
uniform int gravity_place;
OF_STEP(int, batch_step);  // counts from 1

RESULT(0, vec4, force_sum);

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
  batch_step = number;
  instant = number - 1;
  gravity = fetch_load_vec4(gravity, gravity_place, instant).xyz;
  float inverse_mass = fetch_vec4(particle, particle_place, i).x;
  vec3 before = displaced(i);
  vec3 u = before;
  vec3 v = fetch_changing(velocity, velocity_place, i).xyz;
  force_sum = net_force(i);
  free_step(i, acceleration(force_sum.xyz, inverse_mass, gravity), u, v);
  int axes = fixed_axes(i);
#if DIMENSION == 2
  axes = axes | 4;
#endif
  vec3 shift = vec3(0.0);
#ifdef TOOLS
  telling_last = measuring != 0;
  TouchedParticle touched = untouched(i, before, v, fixed_axes(i));
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
#ifdef HOLDS_ONLY  // what presses comes later: press_kernel.glsl, surface_kernel.glsl
  bool touches_now = held.w >= 0.0;
#else
  bool touches_now = true;
#endif
  for (int tool = 0; tool < tool_count && touches_now; ++tool) {
    Reaction reaction = touch_tool(tool, held, instant, touched, dt, inverse_dt);
    TELL_TOOL(tool, i, reaction);
  }
  force_sum = vec4(force_sum.xyz + inverse_dt * touched.impulse, force_sum.w);
  v = touched.v;
  shift = touched.shift;
  if (held.w >= 0.0) axes = 7;  // nothing else pushes it
#endif
  load_rows[pushed_force_place + i] = floatBitsToInt(force_sum);
  load_rows[free_velocity_place + i] = floatBitsToInt(vec4(v, float(axes)));
  load_rows[pushed_shift_place + i] = floatBitsToInt(vec4(shift, inverse_mass));
}
