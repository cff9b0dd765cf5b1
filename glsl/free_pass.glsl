// SPDX-License-Identifier: MIT
//
// Per particle, where it would go by itself and by the tool that holds it; nothing moves yet. Twin of free_kernel.glsl,
// drawn, after reaction_pass.glsl. Needs free_step.glsl, and touch_tools.glsl where TOOLS is defined.

STORED(net, net_place);

// As pushed_tables.glsl has them.
RESULT(0, vec4, force_row);
RESULT(1, vec4, velocity_row);
RESULT(2, vec4, shift_row);

void free_row(int i) {
  float inverse_mass = fetch_vec4(particle, particle_place, i).x;
  vec3 before = displaced(i);
  vec3 u = before;
  vec3 v = fetch_changing(velocity, velocity_place, i).xyz;
  vec4 force = fetch_changing(net, net_place, i);
  free_step(i, acceleration(force.xyz, inverse_mass, gravity), u, v);
  int axes = fixed_axes(i);
#if DIMENSION == 2
  axes = axes | 4;
#endif
#ifdef TOOLS
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  if (held.w >= 0.0) {
    TouchedParticle touched = untouched(i, before, v, fixed_axes(i));
    touch_tool(int(held.w), held, instant, touched, dt, inverse_dt);
    force = vec4(force.xyz + inverse_dt * touched.impulse, force.w);
    v = touched.v;
    axes = 7;  // nothing else pushes it
  }
#endif
  force_row = force;
  velocity_row = vec4(v, float(axes));
  shift_row = vec4(vec3(0.0), inverse_mass);
}

PASS_MAIN(free_row)
