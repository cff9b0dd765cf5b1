// SPDX-License-Identifier: MIT
//
// Per particle, where it would go by itself and by the tools that touch it on the device; nothing moves yet. Needs
// free_step.glsl, and tell_tools.glsl where TOOLS is defined. With HOST_STEP the host acts next, and takes what
// gather_pass.glsl gathers of these rows; without it what pushed_tables.glsl reads is changed by further passes.

RESULT(0, vec4, force_sum);        // N; 1 where the elastic part was cut
RESULT(1, vec4, velocity_before);  // m/s: it would go to x + dt v; axes on which nothing pushes it
#ifdef TOOLS
OF_STEP(int, batch_step);  // counts from 1
#endif

#ifdef HOST_STEP
RESULT(2, vec4, withheld_before);  // N: what the limit of the displacement took from the force
RESULT(3, vec4, speed_before);     // m/s, then nothing: as report_pass.glsl looks for the largest
#else
RESULT(2, vec4, shift_before);     // m, besides, which is no velocity; 1/m, 1/kg
#endif

void free_row(int i) {
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
#ifdef HOST_STEP
  withheld_before = vec4(withheld, 0.0);
  speed_before = vec4(sqrt(inner_product(v, v)), 0.0, 0.0, 0.0);
#else
  shift_before = vec4(vec3(0.0), inverse_mass);
#endif
#ifdef TOOLS
  TouchedParticle touched = untouched(i, before, v, fixed_axes(i));
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  for (int tool = 0; tool < tool_count; ++tool) {
    Reaction reaction = touch_tool(tool, held, instant, touched, dt, inverse_dt);
    TELL_TOOL(tool, i, reaction);
  }
  force_sum = vec4(force_sum.xyz + inverse_dt * touched.impulse, force_sum.w);
  v = touched.v;
  shift_before = vec4(touched.shift, inverse_mass);
#endif
  velocity_before = vec4(v, float(axes));
}

PASS_MAIN(free_row)
