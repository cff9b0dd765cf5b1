// SPDX-License-Identifier: MIT
//
// joint_pass.glsl, dispatched. Needs joint_law.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, joint_count, next_joint_state_place;

void main() {
  int s = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (s >= joint_count) return;
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
  joint_row(s);
  int at = next_joint_state_place + 4 * s;
  load_rows[at] = floatBitsToInt(joint_force);
  load_rows[at + 1] = floatBitsToInt(joint_torque);
  load_rows[at + 2] = floatBitsToInt(joint_force_sum);
  load_rows[at + 3] = floatBitsToInt(joint_torque_sum);
}
