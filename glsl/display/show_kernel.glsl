// SPDX-License-Identifier: MIT
//
// Displacements in the model's order, m. Needs tables.glsl.

layout(local_size_x = GROUP) in;

TABLE_INTS(order, order_place);  // row of the model of a place
uniform int pair, shown_place;

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  displacement_place = pair_place(pair);
  changing_rows[shown_place + fetch_int(order, order_place, i)] = floatBitsToInt(vec4(displaced(i), 0.0));
}
