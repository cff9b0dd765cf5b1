// SPDX-License-Identifier: MIT
//
// Per base row, the forces on its vertices a, b, c and, with the conservative reaction, on its owner: a layer each,
// because a shader cannot add to particles; they gather. Needs displacement.glsl and delta_base.glsl.

uniform isampler2D bases;  // a, b, c, bits of beta
uniform int bases_log2;
uniform sampler2D base_e1;  // X_b - X_a, lambda_b
uniform int base_e1_log2;
uniform sampler2D base_e2;  // X_c - X_a, lambda_c
uniform int base_e2_log2;
uniform isampler2D base_share;  // owner, bits of k_i w_t (conservative) or of w_t (averaged)
uniform int base_share_log2;
uniform float area_exponent;
#ifdef AVERAGED
uniform sampler2D force;  // F_i
uniform int force_log2;
#endif

layout(location = 0) out vec4 on_a;
invariant on_a;
layout(location = 1) out vec4 on_b;
invariant on_b;
layout(location = 2) out vec4 on_c;
invariant on_c;
#ifndef AVERAGED
layout(location = 3) out vec4 on_owner;
invariant on_owner;
#endif

void main() {
  int t = own_row();
  if (t >= row_count) discard;
  ivec4 base = fetch(bases, bases_log2, t);
  ivec4 share = fetch(base_share, base_share_log2, t);
  vec4 e1 = fetch(base_e1, base_e1_log2, t);
  float beta = intBitsToFloat(base.w);
  float k = intBitsToFloat(share.y);
  vec3 u_a = displaced(base.x);
  vec3 d1 = displaced(base.y) - u_a;
#if DIMENSION == 2
  float lambda_c = 0.0;
  vec3 d2 = vec3(0.0);
  DeltaBase now = delta_base_2d(e1.xyz, d1, area_exponent);
#else
  vec4 e2 = fetch(base_e2, base_e2_log2, t);
  float lambda_c = e2.w;
  vec3 d2 = displaced(base.z) - u_a;
  DeltaBase now = delta_base_3d(e1.xyz, e2.xyz, d1, d2, area_exponent);
#endif
#ifdef AVERAGED
  vec3 F = k * fetch(force, force_log2, share.x).xyz;
#else
  vec3 F = k * base_pull(now, u_a - displaced(share.x), d1, d2, e1.w, lambda_c, beta);
  on_owner = vec4(F, 0.0);
#endif
  vec3 a, b, c;
#if DIMENSION == 2
  base_reaction_2d(now, e1.w, beta, F, a, b);
  c = vec3(0.0);
#else
  base_reaction_3d(now, e1.w, lambda_c, beta, F, a, b, c);
#endif
  on_a = vec4(a, 0.0);
  on_b = vec4(b, 0.0);
  on_c = vec4(c, 0.0);
}
