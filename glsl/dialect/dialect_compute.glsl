// SPDX-License-Identifier: MIT
//
// The words of dialect_fragment.glsl for passes that are dispatched. Constants lie one after another in one buffer, in
// rows of 16 bytes, and `place` is a table's first row, or for tables of one or two words a row its first word. What
// passes write lies in another buffer. Floats go by their bits.
//
// Results are declared precise, as those of the others are declared invariant. OpenGL ES 3.1 has no word for it.

#define SLICED
#define ROW_STRIDE SLICE

#ifdef ONE_WORKGROUP
#define SEEN_BY_ALL coherent
#else
#define SEEN_BY_ALL
#endif

#ifndef OWN_BLOCK  // else it reads no constants, and has a block of its own: OpenGL ES 3.1 promises four
layout(std430, binding = 0) readonly buffer ConstantRows {
  ivec4 constant_rows[];
};
layout(std430, binding = 1) readonly buffer ConstantWords {  // the same memory
  int constant_words[];
};
#endif
layout(std430, binding = 2) SEEN_BY_ALL buffer ChangingRows {
  ivec4 changing_rows[];
};
#if defined(PUSHES) || defined(KEPT_VOLUMES)  // what pushes a particle within a step stands there, or sums
#define LOAD_ACCESS SEEN_BY_ALL
#elif defined(TOOLS)  // which tell there what they felt
#define LOAD_ACCESS
#else
#define LOAD_ACCESS readonly
#endif
layout(std430, binding = 3) LOAD_ACCESS buffer LoadRows {
  ivec4 load_rows[];
};

#define TABLE_FLOATS(table, place) uniform int place
#define TABLE_INTS(table, place) uniform int place
#define CHANGING(table, place) int place
#define STORED(table, place) uniform int place
#define STORED_LAYERS(table, place) uniform int place
#define OF_STEP(type, name) type name
#define RESULT(number, type, name) PRECISE type name

#ifndef OWN_BLOCK
ivec2 word_pair(int first) {
  return ivec2(constant_words[first], constant_words[first + 1]);
}
#endif

#define fetch_vec4(table, place, row) intBitsToFloat(constant_rows[place + (row)])
#define fetch_vec2(table, place, row) intBitsToFloat(word_pair(place + 2 * (row)))
#define fetch_float(table, place, row) intBitsToFloat(constant_words[place + (row)])
#define fetch_ivec4(table, place, row) constant_rows[place + (row)]
#define fetch_ivec2(table, place, row) word_pair(place + 2 * (row))
#define fetch_int(table, place, row) constant_words[place + (row)]
#define fetch_changing(table, place, row) intBitsToFloat(changing_rows[place + (row)])
#define fetch_layer(table, place, row, layer) intBitsToFloat(changing_rows[place + 4 * (row) + (layer)])
#define fetch_load_vec4(table, place, row) intBitsToFloat(load_rows[place + (row)])
#define fetch_load_ivec4(table, place, row) load_rows[place + (row)]
#define fetch_load_float(table, place, row) intBitsToFloat(load_rows[place + ((row) >> 2)][(row) & 3])
#define fetch_load_layer(table, place, row, layer) intBitsToFloat(load_rows[place + 4 * (row) + (layer)])

#define PASS_MAIN(compute_row)

uniform int particle_count;  // places 0 ... particle_count - 1 are particles
uniform int place_count;     // rows of a table by place

// The groups of a dispatch form a rectangle where they are too many for a line.
int own_group() {
  return int(gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x);
}

// Pair k of displacements and velocities, which stand before everything else that changes.
int pair_place(int pair) {
  return 2 * pair * place_count;
}
