// SPDX-License-Identifier: MIT
//
// Per particle, its attractor's displacement P*_i - X_i, m, to be drawn: u_i + F_i / k_i, where F_i is the sum of its
// bases' forces. Needs net_force.glsl.

layout(location = 0) out vec4 attractor;
invariant attractor;

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  float k = fetch(particle, particle_log2, i).y;
  vec3 pull = k > 0.0 ? (1.0 / k) * own_force(i) : vec3(0.0);
  attractor = vec4(displaced(i) + pull, 0.0);
}
