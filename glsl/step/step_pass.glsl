// SPDX-License-Identifier: MIT
//
// Per particle, Verlet's step. Gathers the net force itself, or with NET_APART takes what reaction_pass.glsl wrote.
// Needs net_force.glsl, free_step.glsl, measure_step.glsl and, where TOOLS is defined, touch_tools.glsl. Where PUSHED is
// defined it ends what free_pass.glsl began, tools included, and needs pushed_tables.glsl; with HOST_STEP the host has
// pushed, and it needs host_pushes.glsl. Where KEPT_VOLUMES is defined it leaves what kept_step_pass.glsl ends:
// displacement, 1 where a force was cut; velocity; acceleration.

#ifdef NET_APART
STORED_LAYERS(net, net_place);
#endif

void step_row(int i) {
  vec4 old_displacement = fetch_changing(displacement, displacement_place, i);
  vec4 old_velocity = fetch_changing(velocity, velocity_place, i);
  vec4 inertia = fetch_vec4(particle, particle_place, i);
#ifdef PUSHED
  vec4 F = fetch_load_vec4(pushed_force, pushed_force_place, i);
#ifdef HOST_STEP
  int push = push_row(i);
  if (push >= 0) F = vec4(F.xyz + fetch_load_vec4(push_forces, push_forces_place, push).xyz, F.w);
#endif
#elif defined(NET_APART)
  vec4 F = fetch_layer(net, net_place, i, 0);
#else
  vec4 F = net_force(i);
#endif
  vec3 a = acceleration(F.xyz, inertia.x, gravity);
  vec3 u = old_displacement.xyz;
  vec3 v = old_velocity.xyz;
  free_step(i, a, u, v);
#ifdef HOST_STEP
  if (push >= 0) u = u + fetch_load_vec4(push_shifts, push_shifts_place, push).xyz;
#elif defined(PUSHED)
  u = u + fetch_load_vec4(pushed_shift, pushed_shift_place, i).xyz;
#endif
  int fixed_at = fixed_axes(i);
#if defined(TOOLS) && !defined(PUSHED)
  TouchedParticle touched = untouched(i, old_displacement.xyz, v, fixed_at);
  vec4 held = fetch_load_vec4(tool_held, tool_held_place, i);
  for (int tool = 0; tool < tool_count; ++tool) {
    Reaction reaction = touch_tool(tool, held, instant, touched, dt, inverse_dt);
    TELL_TOOL(tool, i, reaction);
  }
  a = acceleration(F.xyz + inverse_dt * touched.impulse, inertia.x, gravity);
  u = old_displacement.xyz;
  v = old_velocity.xyz;
  free_step(i, a, u, v);
  u = u + touched.shift;
#endif
#ifdef KEPT_VOLUMES
  next_displacement = vec4(u, F.w);
  next_velocity = vec4(v, 0.0);
  next_measured = vec4(a, 0.0);
#else
  measure_step(u, v, a, inertia.z, fixed_at, old_displacement.w, old_velocity.w, F.w);
#endif
}

PASS_MAIN(step_row)
