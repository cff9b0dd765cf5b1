// SPDX-License-Identifier: MIT
//
// Per particle, the end of a step in which volumes are kept: from where step_pass.glsl leaves it, so far along its way
// as its volume asks for. As an impulse would have: v gains way / dt, a that over dt. Needs free_step.glsl,
// measure_step.glsl and kept_tables.glsl.

CHANGING(free_displacement, free_displacement_place);  // w: 1 where a force was cut
CHANGING(free_velocity, free_velocity_place);
CHANGING(free_acceleration, free_acceleration_place);

void kept_step_row(int i) {
  vec4 free = fetch_changing(free_displacement, free_displacement_place, i);
  vec3 u = free.xyz;
  vec3 v = fetch_changing(free_velocity, free_velocity_place, i).xyz;
  vec3 a = fetch_changing(free_acceleration, free_acceleration_place, i).xyz;
  int volume = fetch_load_ivec4(kept_ranges, kept_ranges_place, i).z;
  if (volume >= 0) {
    float way = fetch_load_vec4(kept_roots, kept_roots_place, volume).x;
    float speed = inverse_dt * way;
    vec3 along = fetch_load_vec4(kept_along, kept_along_place, i).xyz;
    u = u + way * along;
    v = v + speed * along;
    a = a + (inverse_dt * speed) * along;
  }
  measure_step(u, v, a, fetch_vec4(particle, particle_place, i).z, fixed_axes(i),
               fetch_changing(displacement, displacement_place, i).w, fetch_changing(velocity, velocity_place, i).w,
               free.w);
}

PASS_MAIN(kept_step_row)
