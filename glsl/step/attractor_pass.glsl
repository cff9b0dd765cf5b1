// SPDX-License-Identifier: MIT
//
// Per particle, the force of its attractor, F_i = k_i (P*_i - x_i), N. Needs attractor_pull.glsl or
// attractor_pull_enumerated.glsl.

RESULT(0, vec4, attractor_result);

void attractor_row(int i) {
  vec3 pull = attractor_pull(i, displaced(i));
  attractor_result = vec4(fetch_vec4(particle, particle_place, i).y * pull, 0.0);
}

PASS_MAIN(attractor_row)
