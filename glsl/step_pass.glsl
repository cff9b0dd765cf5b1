// SPDX-License-Identifier: MIT
//
// Per particle, Verlet's step. Gathers the net force itself, or with FOUR_PASSES takes what reaction_pass.glsl wrote.
// Needs net_force.glsl, free_step.glsl and, where TOOLS is defined, touch_tools.glsl. Where PUSHED is defined it ends what
// free_kernel.glsl began, tools included, and needs pushed_tables.glsl.
//
// What a step has to tell rides along, so that no further pass is needed until the batch of steps ends:
//   velocity.w      number of the first step of the batch in which the particle ran away; 0: none, -1: none, but in some
//                   step its elastic force was cut
//   displacement.w  first * 1024 + last step of the batch in which it was not quiet; 0: none

#ifdef FOUR_PASSES
STORED(net, net_place);
#endif
OF_STEP(int, batch_step);  // counts from 1
uniform float runaway_speed, speed_at_rest, acceleration_at_rest;

RESULT(0, vec4, next_displacement);
RESULT(1, vec4, next_velocity);
RESULT(2, vec4, next_measured);  // speed, acceleration, force of the free coordinates; displacement

float length_of(vec3 a) {
  return sqrt(inner_product(a, a));
}

bool finite(vec3 a) {
  return !(any(isnan(a)) || any(isinf(a)));
}

float unquiet_steps(float before, bool quiet) {
  int steps = batch_step == 1 ? 0 : int(before);
  if (quiet) return float(steps);
  int first = steps == 0 ? batch_step : steps >> 10;
  return float(first * 1024 + batch_step);
}

void step_row(int i) {
  vec4 old_displacement = fetch_changing(displacement, displacement_place, i);
  vec4 old_velocity = fetch_changing(velocity, velocity_place, i);
  vec4 inertia = fetch_vec4(particle, particle_place, i);
#ifdef FOUR_PASSES
  vec4 F = fetch_changing(net, net_place, i);
#elif defined(PUSHED)
  vec4 F = fetch_load_vec4(pushed_force, pushed_force_place, i);
#else
  vec4 F = net_force(i);
#endif
  vec3 a = acceleration(F.xyz, inertia.x, gravity);
  vec3 u = old_displacement.xyz;
  vec3 v = old_velocity.xyz;
  free_step(i, a, u, v);
#ifdef PUSHED
  u = u + fetch_load_vec4(pushed_shift, pushed_shift_place, i).xyz;
#endif
  int fixed_at = fixed_axes(i);
#ifdef TOOLS
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

  float speed = length_of(free_part(v, fixed_at));
  float pushed = length_of(free_part(a, fixed_at));
  next_measured = vec4(speed, pushed, inertia.z * pushed, length_of(u));
  bool quiet = speed <= speed_at_rest && pushed <= acceleration_at_rest;
  bool bad = !finite(u) || !finite(v) || !(length_of(v) <= runaway_speed);
  float ran_away = batch_step == 1 ? 0.0 : old_velocity.w;
  if (ran_away <= 0.0) ran_away = bad ? float(batch_step) : min(ran_away, -F.w);
  next_displacement = vec4(u, unquiet_steps(old_displacement.w, quiet));
  next_velocity = vec4(v, ran_away);
}

PASS_MAIN(step_row)
