// SPDX-License-Identifier: MIT
//
// Displacements, or with ATTRACTOR those of the attractors, in the model's order, m. Needs tables.glsl, with ATTRACTOR
// shown_attractor_pass.glsl.

layout(local_size_x = GROUP) in;

TABLE_INTS(order, order_place);  // row of the model of a place
uniform int pair, shown_place;

void main() {
  int i = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (i >= particle_count) return;
  displacement_place = pair_place(pair);
#ifdef ATTRACTOR
  shown_attractor_row(i);
  vec4 shown = attractor;
#else
  vec4 shown = vec4(displaced(i), 0.0);
#endif
  changing_rows[shown_place + fetch_int(order, order_place, i)] = floatBitsToInt(shown);
}
