// SPDX-License-Identifier: MIT
//
// P*_i - x_i = sum_j alpha_ij (u_j - u_i) + sum_t w_t beta_t (g n_t - n0_t), with the thesis' tables.
// Needs displacement.glsl and delta_base.glsl.

uniform isampler2D index;  // Nc, X, Bc, X'
uniform int index_log2;
uniform isampler2D neighbours;
uniform int neighbours_log2;
uniform sampler2D alpha;
uniform int alpha_log2;
uniform isampler2D bases;  // a, b, c, bits of beta
uniform int bases_log2;
uniform sampler2D base_e1;
uniform int base_e1_log2;
uniform sampler2D base_e2;
uniform int base_e2_log2;
uniform isampler2D base_share;  // owner, bits of w_t
uniform int base_share_log2;
uniform float area_exponent;

vec3 base_change(int t) {
  ivec4 base = fetch(bases, bases_log2, t);
  vec3 u_a = displaced(base.x);
  vec3 d1 = displaced(base.y) - u_a;
  vec3 E1 = fetch(base_e1, base_e1_log2, t).xyz;
#if DIMENSION == 2
  return delta_base_2d(E1, d1, area_exponent).change;
#else
  vec3 E2 = fetch(base_e2, base_e2_log2, t).xyz;
  return delta_base_3d(E1, E2, d1, displaced(base.z) - u_a, area_exponent).change;
#endif
}

vec3 attractor_pull(int i, vec3 u_i) {
  ivec4 at = fetch(index, index_log2, i);
  if (at.z == 0) return vec3(0.0);
  vec3 pull = vec3(0.0);
  for (int r = at.y; r < at.y + at.x; ++r) {
    int j = fetch(neighbours, neighbours_log2, r).x;
    pull = pull + fetch(alpha, alpha_log2, r).x * (displaced(j) - u_i);
  }
  for (int t = at.w; t < at.w + at.z; ++t) {
    float beta = intBitsToFloat(fetch(bases, bases_log2, t).w);
    float w = intBitsToFloat(fetch(base_share, base_share_log2, t).y);
    pull = pull + (w * beta) * base_change(t);
  }
  return pull;
}
