// SPDX-License-Identifier: MIT
//
// Per particle, the force F_i = k_i (P*_i - x_i), N, from the pull that the attractor pass wrote. Needs tables.glsl.

STORED(pull, pull_place);

RESULT(0, vec4, force_result);

void force_row(int i) {
  force_result =
      vec4(fetch_vec4(particle, particle_place, i).y * fetch_changing(pull, pull_place, i).xyz, 0.0);
}

PASS_MAIN(force_row)
