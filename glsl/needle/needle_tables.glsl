// SPDX-License-Identifier: MIT
//
// Needles, as in src/gl/compute/compute_needles.h, and where one is in a step: twin of NeedlePath of src/cpu. Every lane of the
// group knows its law and its state. Needs pushed_tables.glsl, tool_tables.glsl, vector3.glsl and lone_group.glsl.
//
// Words: 20 a needle for its law; the body's facets, three places each; the place of each particle of the model;
// states. A state is a header of 16 words; along, x, y, 0 for each force on a shaft that bends; for each node of the hole the
// number of its particles and whether it slides; for each node its particles, in the model's order, and their weights.

layout(std430, binding = 0) SEEN_BY_ALL buffer NeedleWords {
  int needle_words[];
};

uniform int needle;  // row of it among needles
uniform int needle_facets, facet_count, needle_order, model_count;
uniform int pair, number;  // state at the step's start; step of the batch, from 1

const int law_words = 20;
const int header_words = 16;
// Of the header: nodes, 1 where punctured, 1 where through, slip, forces on the shaft, the first step of the batch that
// there was no room for (0: none), nodes whose coupling is known; then what a step goes on with in another dispatch.
const int count_word = 0, punctured_word = 1, through_word = 2, slip_word = 3, loads_word = 4, full_word = 5;
const int coupled_word = 6, stage_word = 7, left_word = 8, reach_word = 9, first_word = 10, way_word = 11;

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

float law_real(int word) {
  return intBitsToFloat(needle_words[law_words * needle + word]);
}

vec4 frame_row(int at, int row) {
  return fetch_load_vec4(tool_frames, tool_frames_place, 7 * (at * tool_count + needle_tool) + row);
}

void begin_needle() {
  int law = law_words * needle;
  state_place = needle_words[law];
  coupling_place = needle_words[law + 1];
  stiffness_place = needle_words[law + 2];
  inverse_place = needle_words[law + 3];
  share_place = needle_words[law + 4];
  longest = needle_words[law + 5];
  most_around = needle_words[law + 6];
  needle_tool = needle_words[law + 7];
  needle_length = law_real(8);
  needle_radius = law_real(9);
  puncture = law_real(10);
  cutting = law_real(11);
  static_friction = law_real(12);
  kinetic_friction = law_real(13);
  surface_friction = law_real(14);
  spread = law_real(15);
  first_reach = law_real(16);
  bending_stiffness = law_real(17);
  node_count = state_word(count_word);
  punctured = state_word(punctured_word) != 0;
  through = state_word(through_word) != 0;
  slip = state_real(slip_word);
  shaft_loads = state_word(loads_word);
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
  return state_place + header_words + 4 * k;
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
  return state_place + header_words + (bending_stiffness > 0.0 ? 4 * longest : 0) + 2 * k;
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
