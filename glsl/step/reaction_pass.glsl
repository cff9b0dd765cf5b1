// SPDX-License-Identifier: MIT
//
// Per particle, the net force, N, where several passes need it. Needs net_force.glsl.

RESULT(0, vec4, net_result);

void reaction_row(int i) {
  net_result = net_force(i);
}

PASS_MAIN(reaction_row)
