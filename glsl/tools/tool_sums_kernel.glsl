// SPDX-License-Identifier: MIT
//
// Sums of what tell_tools.glsl wrote: four rows for each tool and part of its rows, a group each, then of those parts.

layout(local_size_x = GROUP) in;

uniform int source_place, source_count, source_stride;  // rows of four, of a tool; from one tool's to the next's
uniform int part_count, sums_place;

shared vec4 group_force[GROUP];
shared vec4 group_torque[GROUP];
shared vec4 group_last_force[GROUP];
shared vec4 group_last_torque[GROUP];

void main() {
  int lane = int(gl_LocalInvocationID.x);
  int tool = own_group() / part_count;
  int part = own_group() - tool * part_count;
  vec4 force = vec4(0.0);
  vec4 torque = vec4(0.0);
  vec4 last_force = vec4(0.0);
  vec4 last_torque = vec4(0.0);
  for (int row = part * GROUP + lane; row < source_count; row += part_count * GROUP) {
    int at = source_place + 4 * (tool * source_stride + row);
    force += intBitsToFloat(load_rows[at]);
    torque += intBitsToFloat(load_rows[at + 1]);
    last_force += intBitsToFloat(load_rows[at + 2]);
    last_torque += intBitsToFloat(load_rows[at + 3]);
  }
  group_force[lane] = force;
  group_torque[lane] = torque;
  group_last_force[lane] = last_force;
  group_last_torque[lane] = last_torque;
  for (int half_of = GROUP / 2; half_of > 0; half_of /= 2) {
    memoryBarrierShared();
    barrier();
    if (lane < half_of) {
      group_force[lane] += group_force[lane + half_of];
      group_torque[lane] += group_torque[lane + half_of];
      group_last_force[lane] += group_last_force[lane + half_of];
      group_last_torque[lane] += group_last_torque[lane + half_of];
    }
  }
  if (lane > 0) return;
  int to = sums_place + 4 * (tool * part_count + part);
  load_rows[to] = floatBitsToInt(group_force[0]);
  load_rows[to + 1] = floatBitsToInt(group_torque[0]);
  load_rows[to + 2] = floatBitsToInt(group_last_force[0]);
  load_rows[to + 3] = floatBitsToInt(group_last_torque[0]);
}
