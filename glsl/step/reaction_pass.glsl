// SPDX-License-Identifier: MIT
//
// Per particle, the net force and what was withheld from it, N, where several passes need them. Needs net_force.glsl.

RESULT(0, vec4, net_result);  // w: 1 where the elastic part was cut
RESULT(1, vec4, withheld_result);

void reaction_row(int i) {
  net_result = net_force(i);
  withheld_result = vec4(withheld, 0.0);
}

PASS_MAIN(reaction_row)
