// SPDX-License-Identifier: MIT
//
// P*_i - x_i = sum_j alpha_ij (u_j - u_i) + sum_t w_t beta_t (n_t - n0_t), with the thesis' tables.
// Needs tables.glsl and base.glsl.

vec3 base_change(int t) {
  ivec4 base = fetch_ivec4(bases, bases_place, t);
  vec3 u_a = displaced(base.x);
  vec3 d1 = displaced(base.y) - u_a;
  vec3 E1 = fetch_vec4(base_e1, base_e1_place, t).xyz;
#if DIMENSION == 2
  return delta_base_2d(E1, d1).dn;
#else
  vec3 E2 = fetch_vec4(base_e2, base_e2_place, t).xyz;
  return delta_base_3d(E1, E2, d1, displaced(base.z) - u_a).dn;
#endif
}

vec3 attractor_pull(int i, vec3 u_i) {
  ivec2 own = base_rows(i);
  if (own.x == own.y) return vec3(0.0);
  vec3 pull = vec3(0.0);
  ivec2 near = neighbour_rows(i);
  for (int r = near.x; r < near.y; r += ROW_STRIDE) {
    int j = fetch_int(neighbours, neighbours_place, r);
    pull = pull + fetch_float(alpha, alpha_place, r) * (displaced(j) - u_i);
  }
  for (int t = own.x; t < own.y; t += ROW_STRIDE) {
    float beta = intBitsToFloat(fetch_ivec4(bases, bases_place, t).w);
    float w = intBitsToFloat(fetch_ivec2(base_share, base_share_place, t).y);
    pull = pull + (w * beta) * base_change(t);
  }
  return pull;
}
