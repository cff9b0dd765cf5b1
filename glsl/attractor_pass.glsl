// SPDX-License-Identifier: MIT
//
// Per particle, what its attractor does. Needs attractor_pull.glsl or attractor_pull_enumerated.glsl.
// The force F_i = k_i (P*_i - x_i), N; with FOUR_PASSES the pull P*_i - x_i, m, of which force_pass.glsl makes the force.

uniform sampler2D particle;  // 1/m, k_i, m
uniform int particle_log2;

layout(location = 0) out vec4 result;
invariant result;

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  vec3 u_i = displaced(i);
  vec3 pull = attractor_pull(i, u_i);
#ifdef FOUR_PASSES
  result = vec4(pull, 0.0);
#else
  result = vec4(fetch(particle, particle_log2, i).y * pull, 0.0);
#endif
}
