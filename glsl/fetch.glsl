// SPDX-License-Identifier: MIT
//
// Rows of tables: row r of a table whose width is 2^l is texel (r mod 2^l, r / 2^l).
//
// Passes declare what they write invariant: a compiler then keeps the order of operations of the source (Mesa would
// turn a - b + c into a + c - b), and every program, on any visit, gives the same bits for the same kernel.

uniform int target_log2;  // of the rectangle that is drawn
uniform int row_count;    // rows of it that mean something

ivec2 texel_of(int row, int log2_width) {
  return ivec2(row & ((1 << log2_width) - 1), row >> log2_width);
}

vec4 fetch(sampler2D table, int log2_width, int row) {
  return texelFetch(table, texel_of(row, log2_width), 0);
}

ivec4 fetch(isampler2D table, int log2_width, int row) {
  return texelFetch(table, texel_of(row, log2_width), 0);
}

vec4 fetch(sampler2DArray table, int log2_width, int row, int layer) {
  return texelFetch(table, ivec3(texel_of(row, log2_width), layer), 0);
}

// The row this fragment computes.
int own_row() {
  return (int(gl_FragCoord.y) << target_log2) + int(gl_FragCoord.x);
}
