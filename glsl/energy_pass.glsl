// SPDX-License-Identifier: MIT
//
// Per particle, J: elastic energy of its own attractor or bases and half of its springs'; kinetic energy 1/2 m v- . v+
// with the velocities half a step before and after; energy in the scene's gravity. Needs net_force.glsl and
// integrate_displacement.glsl; the forces are those of the present state.

uniform sampler2D velocity;
uniform int velocity_log2;
#ifdef CONSERVATIVE
uniform isampler2D base_share;  // owner, bits of k_i w_t
uniform int base_share_log2;
#endif
uniform vec3 gravity;  // m/s^2, with uniform accelerations
uniform float dt;      // of the last step

layout(location = 0) out vec4 energy;
invariant energy;

// 1/2 F^2 / k: of a force that is k times what it pulls over.
float pull_energy_of(vec3 F, float k) {
  return k > 0.0 ? 0.5 * inner_product(F, F) / k : 0.0;
}

float own_elastic(int i, float k_i) {
  float sum = 0.0;
#ifdef ATTRACTORS
  sum = pull_energy_of(fetch(force, force_log2, i).xyz, k_i);
#endif
#ifdef CONSERVATIVE
  ivec4 at = fetch(index, index_log2, i);
  for (int t = at.w; t < at.w + at.z; ++t) {
    float k = intBitsToFloat(fetch(base_share, base_share_log2, t).y);
    sum = sum + pull_energy_of(fetch(base_terms, base_terms_log2, t, 3).xyz, k);
  }
#endif
#ifdef SPRINGS
  vec3 u_i = displaced(i);
  int end = fetch(lists, lists_log2, i + 1).w;
  for (int row = fetch(lists, lists_log2, i).w; row < end; ++row) {
    int other = fetch(entries, entries_log2, spring_start + row).x;
    vec4 pull = fetch(spring, spring_log2, row);
    sum = sum + 0.5 * spring_energy(pull.xyz, displaced(other) - u_i, pull.w);
  }
#endif
  return sum;
}

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  vec3 u = displaced(i);
  vec3 v = fetch(velocity, velocity_log2, i).xyz;
  vec4 inertia = fetch(particle, particle_log2, i);
  vec3 gained = dt * free_part(acceleration(net_force(i).xyz, inertia.x, gravity), fixed_axes(i));
  float kinetic = 0.5 * inertia.z * inner_product(v, v + gained);
  energy = vec4(own_elastic(i, inertia.y), kinetic, -(inertia.z * inner_product(gravity, u)), 0.0);
}
