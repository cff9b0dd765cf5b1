// SPDX-License-Identifier: MIT
//
// Three rows for each that the host asks for. Needs gather_pass.glsl.

layout(local_size_x = GROUP) in;

uniform int pair, gather_count, gathered_place;

void main() {
  int row = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (row >= gather_count) return;
  displacement_place = pair_place(pair);
  gather_row(row);
  load_rows[gathered_place + 3 * row] = floatBitsToInt(gathered_displacement);
  load_rows[gathered_place + 3 * row + 1] = floatBitsToInt(gathered_velocity);
  load_rows[gathered_place + 3 * row + 2] = floatBitsToInt(gathered_withheld);
}
