// SPDX-License-Identifier: MIT
//
// Per particle, what its attractor does. Needs attractor_pull.glsl or attractor_pull_enumerated.glsl.
// The force F_i = k_i (P*_i - x_i), N; with FOUR_PASSES the pull P*_i - x_i, m, of which force_pass.glsl makes the force.

RESULT(0, vec4, attractor_result);

void attractor_row(int i) {
  vec3 pull = attractor_pull(i, displaced(i));
#ifdef FOUR_PASSES
  attractor_result = vec4(pull, 0.0);
#else
  attractor_result = vec4(fetch_vec4(particle, particle_place, i).y * pull, 0.0);
#endif
}

PASS_MAIN(attractor_row)
