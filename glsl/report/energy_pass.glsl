// SPDX-License-Identifier: MIT
//
// Per particle, J: elastic energy of its own attractor or bases and half of its springs'; kinetic energy 1/2 m v- . v+
// with the velocities half a step before and after; energy in the scene's gravity. Needs net_force.glsl and
// integrate.glsl; the forces are those of the present state.

OF_STEP(vec3, gravity);  // m/s^2, with uniform accelerations
uniform float dt;        // of the last step

RESULT(0, vec4, energy);

// 1/2 F^2 / k: of a force that is k times what it pulls over.
float pull_energy_of(vec3 F, float k) {
  return k > 0.0 ? 0.5 * inner_product(F, F) / k : 0.0;
}

float own_elastic(int i, float k_i) {
  float sum = 0.0;
#ifdef ATTRACTORS
  sum = pull_energy_of(force_of(i), k_i);
#endif
#ifdef CONSERVATIVE
  ivec2 own = base_rows(i);
  for (int t = own.x; t < own.y; t += ROW_STRIDE) {
    float k = intBitsToFloat(fetch_ivec2(base_share, base_share_place, t).y);
    sum = sum + pull_energy_of(base_term(t, 3), k);
  }
#endif
#ifdef SPRINGS
  vec3 u_i = displaced(i);
  ivec2 springs = spring_rows(i);
  for (int row = springs.x; row < springs.y; row += ROW_STRIDE) {
    int other = fetch_int(entries, entries_place, spring_start + row);
    vec4 pull = fetch_vec4(spring, spring_place, row);
    sum = sum + 0.5 * spring_energy(pull.xyz, displaced(other) - u_i, pull.w);
  }
#endif
  return sum;
}

void energy_row(int i) {
  vec3 u = displaced(i);
  vec3 v = fetch_changing(velocity, velocity_place, i).xyz;
  vec4 inertia = fetch_vec4(particle, particle_place, i);
  vec3 gained = dt * free_part(acceleration(net_force(i).xyz, inertia.x, gravity), fixed_axes(i));
  float kinetic = 0.5 * inertia.z * inner_product(v, v + gained);
  energy = vec4(own_elastic(i, inertia.y), kinetic, -(inertia.z * inner_product(gravity, u)), 0.0);
}

PASS_MAIN(energy_row)
