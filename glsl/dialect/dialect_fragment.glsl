// SPDX-License-Identifier: MIT
//
// How passes that are drawn read their tables and write their results; dialect_compute.glsl has the same words for
// passes that are dispatched. A table is a texture: row r of one whose width is 2^place is texel
// (r mod 2^place, r / 2^place). A pass is a function of a row, which PASS_MAIN calls for every fragment.
//
// Results are declared invariant: a compiler then keeps the order of operations of the source (Mesa would turn
// a - b + c into a + c - b), and every program, on any visit, gives the same bits for the same kernel.

uniform int target_log2;  // of the rectangle that is drawn
uniform int row_count;    // rows of it that mean something

// Rows of one particle follow each other at this distance.
#define ROW_STRIDE 1

// Constants; the state, whose place changes from step to step; what passes write and others read. Names are spelt out,
// because ES 3.00 cannot join them.
#define TABLE_FLOATS(table, place) uniform sampler2D table; uniform int place
#define TABLE_INTS(table, place) uniform isampler2D table; uniform int place
#define CHANGING(table, place) TABLE_FLOATS(table, place)
#define STORED(table, place) TABLE_FLOATS(table, place)
#define STORED_LAYERS(table, place) uniform sampler2DArray table; uniform int place
// What differs from step to step.
#define OF_STEP(type, name) uniform type name
#define RESULT(number, type, name) layout(location = number) out type name; invariant name

ivec2 texel_of(int row, int log2_width) {
  return ivec2(row & ((1 << log2_width) - 1), row >> log2_width);
}

#define fetch_vec4(table, place, row) texelFetch(table, texel_of(row, place), 0)
#define fetch_vec2(table, place, row) texelFetch(table, texel_of(row, place), 0).xy
#define fetch_float(table, place, row) texelFetch(table, texel_of(row, place), 0).x
#define fetch_ivec4(table, place, row) texelFetch(table, texel_of(row, place), 0)
#define fetch_ivec2(table, place, row) texelFetch(table, texel_of(row, place), 0).xy
#define fetch_int(table, place, row) texelFetch(table, texel_of(row, place), 0).x
#define fetch_changing(table, place, row) fetch_vec4(table, place, row)
#define fetch_layer(table, place, row, layer) texelFetch(table, ivec3(texel_of(row, place), layer), 0)
#define fetch_load_vec4(table, place, row) fetch_vec4(table, place, row)
#define fetch_load_ivec4(table, place, row) fetch_ivec4(table, place, row)
#define fetch_load_float(table, place, row) fetch_float(table, place, row)
#define fetch_load_layer(table, place, row, layer) fetch_layer(table, place, row, layer)

// The row this fragment computes.
int own_row() {
  return (int(gl_FragCoord.y) << target_log2) + int(gl_FragCoord.x);
}

// Tools have a pass of their own to tell what they felt.
#define TELL_TOOL(tool, i, reaction)

#define PASS_MAIN(compute_row) void main() { if (own_row() >= row_count) discard; compute_row(own_row()); }
