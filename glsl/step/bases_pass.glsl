// SPDX-License-Identifier: MIT
//
// Per base row, the forces on its vertices a, b, c and, with the conservative reaction, on its owner, because a shader
// cannot add to particles; they gather. Needs tables.glsl and base.glsl, with AVERAGED force_of.glsl.

RESULT(0, vec4, base_on_a);
RESULT(1, vec4, base_on_b);
RESULT(2, vec4, base_on_c);
#ifndef AVERAGED
RESULT(3, vec4, base_on_owner);
#endif

void base_row(int t) {
  ivec4 base = fetch_ivec4(bases, bases_place, t);
  ivec2 given = fetch_ivec2(base_share, base_share_place, t);
  vec4 e1 = fetch_vec4(base_e1, base_e1_place, t);
  float beta = intBitsToFloat(base.w);
  float k = intBitsToFloat(given.y);
  vec3 u_a = displaced(base.x);
  vec3 d1 = displaced(base.y) - u_a;
#if DIMENSION == 2
  float lambda_c = 0.0;
  vec3 d2 = vec3(0.0);
  DeltaBase now = delta_base_2d(e1.xyz, d1);
#else
  vec4 e2 = fetch_vec4(base_e2, base_e2_place, t);
  float lambda_c = e2.w;
  vec3 d2 = displaced(base.z) - u_a;
  DeltaBase now = delta_base_3d(e1.xyz, e2.xyz, d1, d2);
#endif
#ifdef AVERAGED
  vec3 F = k * force_of(given.x);
#else
  vec3 F = k * base_pull(now, u_a - displaced(given.x), d1, d2, e1.w, lambda_c, beta);
  base_on_owner = vec4(F, 0.0);
#endif
  vec3 a, b, c;
#if DIMENSION == 2
  base_reaction_2d(now, e1.w, beta, F, a, b);
  c = vec3(0.0);
#else
  base_reaction_3d(now, e1.w, lambda_c, beta, F, a, b, c);
#endif
  base_on_a = vec4(a, 0.0);
  base_on_b = vec4(b, 0.0);
  base_on_c = vec4(c, 0.0);
}

PASS_MAIN(base_row)
