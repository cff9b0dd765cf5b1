// SPDX-License-Identifier: MIT
//
// Per particle, where it would go by itself and by the tools that touch it (HOLDS_ONLY: that hold it); nothing moves yet: free_kernel.glsl, drawn.
// Gathers the net force itself, or with NET_APART takes what reaction_pass.glsl wrote. Needs free_step.glsl and, where
// TOOLS is defined, touch_tools.glsl, whose reactions tools_pass.glsl tells.

#ifdef NET_APART
STORED(net, net_place);
#endif

// As pushed_tables.glsl reads them.
RESULT(0, vec4, force_sum);
RESULT(1, vec4, velocity_before);
RESULT(2, vec4, shift_before);

void free_row(int i) {
  float inverse_mass = fetch_vec4(particle, particle_place, i).x;
  vec3 before = displaced(i);
  vec3 u = before;
  vec3 v = fetch_changing(velocity, velocity_place, i).xyz;
#ifdef NET_APART
  force_sum = fetch_changing(net, net_place, i);
#else
  force_sum = net_force(i);
#endif
  free_step(i, acceleration(force_sum.xyz, inverse_mass, gravity), u, v);
  int axes = fixed_axes(i);
#if DIMENSION == 2
  axes = axes | 4;
#endif
  vec3 shift = vec3(0.0);
#ifdef TOOLS
  TouchedParticle touched = untouched(i, before, v, fixed_axes(i));
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
#ifdef HOLDS_ONLY
  if (held.w >= 0.0) touch_tool(int(held.w), held, instant, touched, dt, inverse_dt);
#else
  for (int tool = 0; tool < tool_count; ++tool) touch_tool(tool, held, instant, touched, dt, inverse_dt);
#endif
  force_sum = vec4(force_sum.xyz + inverse_dt * touched.impulse, force_sum.w);
  v = touched.v;
  shift = touched.shift;
  if (held.w >= 0.0) axes = 7;  // nothing else pushes it
#endif
  velocity_before = vec4(v, float(axes));
  shift_before = vec4(shift, inverse_mass);
}

PASS_MAIN(free_row)
