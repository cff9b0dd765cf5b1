// SPDX-License-Identifier: MIT
//
// Per particle, what its attractor does. Needs attractor_pull.glsl or attractor_pull_enumerated.glsl.
//   RESULT 0: the force F_i = k_i (P*_i - x_i), N
//   RESULT 1: the pull P*_i - x_i, m, of which force_pass.glsl makes the force
//   RESULT 2: the attractor's displacement P*_i - X_i, m, to be drawn

uniform sampler2D particle;  // 1/m, k_i, m
uniform int particle_log2;

layout(location = 0) out vec4 result;

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  vec3 u_i = displaced(i);
  vec3 pull = attractor_pull(i, u_i);
#if RESULT == 0
  result = vec4(fetch(particle, particle_log2, i).y * pull, 0.0);
#elif RESULT == 1
  result = vec4(pull, 0.0);
#else
  result = vec4(u_i + pull, 0.0);
#endif
}
