// SPDX-License-Identifier: MIT
//
// Where a particle goes with an acceleration: Verlet's step, then what is imposed on it. Needs net_force.glsl and
// integrate.glsl.

OF_STEP(vec3, gravity);  // m/s^2
uniform float dt, inverse_dt, damping_factor;

void free_step(int i, vec3 a, inout vec3 u, inout vec3 v) {
#ifdef FIXED
  vec3 before = u;
#endif
  integrate_displacement(u, v, a, dt, damping_factor);
#ifdef FIXED
  ivec4 rows = fetch_load_ivec4(load_index, load_index_place, i);
  vec3 target = load_sum(rows.z, rows.z + (rows.w >> 3), instant + 1);
  impose(u, v, rows.w & 7, target, before, inverse_dt);
#endif
}
