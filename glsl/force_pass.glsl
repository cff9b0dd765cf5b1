// SPDX-License-Identifier: MIT
//
// Per particle, the force F_i = k_i (P*_i - x_i), N, from the pull that the attractor pass wrote. Needs fetch.glsl.

uniform sampler2D pull;
uniform int pull_log2;
uniform sampler2D particle;  // 1/m, k_i, m
uniform int particle_log2;

layout(location = 0) out vec4 force;
invariant force;

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  force = vec4(fetch(particle, particle_log2, i).y * fetch(pull, pull_log2, i).xyz, 0.0);
}
