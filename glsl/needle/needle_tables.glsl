// SPDX-License-Identifier: MIT
//
// Needles, as in src/gl/compute/compute_needles.h, and where one is in a step: twin of NeedlePath of src/cpu. Every lane of the
// group knows its law and its state. Needs pushed_tables.glsl, tool_tables.glsl, kernel_language.glsl and lone_group.glsl.
//
// Words: LAW_WORDS a needle for its law; the body's facets, three places each; the place of each particle of the model;
// states. A state is a header of HEADER_WORDS words; along, x, y, 0 for each force on a shaft that bends; for each node of the hole the
// number of its particles and whether it slides; for each node its particles, in the model's order, and their weights.

layout(std430, binding = 0) SEEN_BY_ALL buffer NeedleWords {
  int needle_words[];
};

uniform int needle;  // row of it among needles
uniform int needle_facets, facet_count, needle_order, model_count;
uniform int pair, number;  // state at the step's start; step of the batch, from 1

// Which word of a law or a header is which: LawWord and HeaderWord there, as LAW_... and HEADER_...

int state_place, coupling_place, stiffness_place, inverse_place, share_place;
int longest, most_around, needle_tool;  // nodes of a hole, particles of a node: room for
float needle_length, needle_radius, puncture, cutting, static_friction, kinetic_friction, surface_friction;  // N, N/m
float spread, first_reach;                                                                                  // m
float bending_stiffness;                                                                                    // N m^2

int node_count;
bool punctured, through;
float slip;
int shaft_loads;

vec3 tip_high, tip_low;       // at the step's start, as a sum
vec3 axis_x, axis_y, axis;    // likewise; axis points to the hub
int displacement_place;

int state_word(int word) {
  return needle_words[state_place + word];
}

float state_real(int word) {
  return intBitsToFloat(state_word(word));
}

int law_word(int word) {
  return needle_words[LAW_WORDS * needle + word];
}

float law_real(int word) {
  return intBitsToFloat(law_word(word));
}

vec4 frame_row(int at, int row) {
  return fetch_load_vec4(tool_frames, tool_frames_place, TOOL_FRAME_ROWS * (at * tool_count + needle_tool) + row);
}

void begin_needle() {
  state_place = law_word(LAW_STATE);
  coupling_place = law_word(LAW_COUPLING);
  stiffness_place = law_word(LAW_STIFFNESS);
  inverse_place = law_word(LAW_INVERSE);
  share_place = law_word(LAW_SHARE);
  longest = law_word(LAW_NODES);
  most_around = law_word(LAW_PARTICLES);
  needle_tool = law_word(LAW_TOOL);
  needle_length = law_real(LAW_LENGTH);
  needle_radius = law_real(LAW_RADIUS);
  puncture = law_real(LAW_PUNCTURE);
  cutting = law_real(LAW_CUTTING);
  static_friction = law_real(LAW_STATIC_FRICTION);
  kinetic_friction = law_real(LAW_KINETIC_FRICTION);
  surface_friction = law_real(LAW_SURFACE_FRICTION);
  spread = law_real(LAW_SPREAD);
  first_reach = law_real(LAW_REACH);
  bending_stiffness = law_real(LAW_BENDING_STIFFNESS);
  node_count = state_word(HEADER_COUNT);
  punctured = state_word(HEADER_PUNCTURED) != 0;
  through = state_word(HEADER_THROUGH) != 0;
  slip = state_real(HEADER_SLIP);
  shaft_loads = state_word(HEADER_LOADS);
  vec4 x = frame_row(number - 1, 0);
  vec4 y = frame_row(number - 1, 1);
  vec4 z = frame_row(number - 1, 2);
  axis_x = x.xyz;
  axis_y = y.xyz;
  axis = z.xyz;
  tip_high = vec3(x.w, y.w, z.w);
  tip_low = frame_row(number - 1, 3).xyz;
  displacement_place = pair_place(pair);
}

int load_place(int k) {
  return state_place + HEADER_WORDS + 4 * k;
}

// Of a force on the shaft: m along it, N along the tool's x and y.
vec3 shaft_load(int k) {
  int at = load_place(k);
  return intBitsToFloat(ivec3(needle_words[at], needle_words[at + 1], needle_words[at + 2]));
}

ivec3 facet_corners(int t) {
  int corner = needle_facets + 3 * t;
  return ivec3(needle_words[corner], needle_words[corner + 1], needle_words[corner + 2]);
}

int node_words(int k) {
  return state_place + HEADER_WORDS + (bending_stiffness > 0.0 ? 4 * longest : 0) + 2 * k;
}

int around(int k) {
  return needle_words[node_words(k)];
}

int list_place(int k) {
  return node_words(longest) + 2 * most_around * k;
}

int particle_of(int k, int j) {
  return needle_words[list_place(k) + j];
}

float weight_of(int k, int j) {
  return intBitsToFloat(needle_words[list_place(k) + most_around + j]);
}

vec3 displaced_by(int i) {
  return intBitsToFloat(changing_rows[displacement_place + i]).xyz;
}

// Of a particle at the step's start, from the tip, m.
vec3 place_of(int i) {
  vec3 high = fetch_load_vec4(tool_rest, tool_rest_place, 2 * i).xyz - tip_high;
  vec3 low = fetch_load_vec4(tool_rest, tool_rest_place, 2 * i + 1).xyz - tip_low;
  return (high + low) + displaced_by(i);
}

bool is_held(int i) {
  return fetch_load_vec4(tool_held, tool_held_place, i).w >= 0.0;
}

// How a node's row of coupling with another one is stored: 1/kg along the axes, and of one number for all of them.
int coupling_row(int k, int other) {
  return coupling_place + 4 * (k * longest + other);
}
