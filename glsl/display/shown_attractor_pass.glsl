// SPDX-License-Identifier: MIT
//
// Per particle, its attractor's displacement P*_i - X_i, m, to be drawn: u_i + F_i / k_i, where F_i is the sum of its
// bases' forces. Needs net_force.glsl.

RESULT(0, vec4, attractor);

void shown_attractor_row(int i) {
  float k = fetch_vec4(particle, particle_place, i).y;
  vec3 pull = k > 0.0 ? (1.0 / k) * own_force(i) : vec3(0.0);
  attractor = vec4(displaced(i) + pull, 0.0);
}

PASS_MAIN(shown_attractor_row)
