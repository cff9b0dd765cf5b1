// SPDX-License-Identifier: MIT
//
// Of what tools_pass.glsl wrote, ROWS_TO_ONE rows of a tool to one, added. Drawn only; needs dialect_fragment.glsl.

STORED(forces, forces_place);
STORED(torques, torques_place);
STORED(last_forces, last_forces_place);
STORED(last_torques, last_torques_place);
uniform int source_count, result_count;  // rows a tool: of these, and of what is drawn

RESULT(0, vec4, force_sum);
RESULT(1, vec4, torque_sum);
RESULT(2, vec4, last_force);
RESULT(3, vec4, last_torque);

void sum_row(int row) {
  int tool = row / result_count;
  int first = ROWS_TO_ONE * (row - tool * result_count);
  int end = min(first + ROWS_TO_ONE, source_count);
  force_sum = vec4(0.0);
  torque_sum = vec4(0.0);
  last_force = vec4(0.0);
  last_torque = vec4(0.0);
  for (int k = first; k < end; ++k) {
    int source = tool * source_count + k;
    force_sum = force_sum + fetch_changing(forces, forces_place, source);
    torque_sum = torque_sum + fetch_changing(torques, torques_place, source);
    last_force = last_force + fetch_changing(last_forces, last_forces_place, source);
    last_torque = last_torque + fetch_changing(last_torques, last_torques_place, source);
  }
}

PASS_MAIN(sum_row)
