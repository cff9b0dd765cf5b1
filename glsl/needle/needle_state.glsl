// SPDX-License-Identifier: MIT
//
// Needles by fragments, as in src/gl/fragment/fragment_needles.h, and where one is in a step: the words of needle_tables.glsl for
// passes that are drawn. Every fragment knows the needle's law and its state. Needs tables.glsl, vector3.glsl,
// pushed_tables.glsl and tool_tables.glsl.
//
// Rows of a state: a header of 4; what its hub has felt, 4; for each node of the hole how many particles it is a mean of,
// and 1 where it slides; along, x, y for each force on a shaft that bends. Lists have room for most_around rows a node:
// its particles, in the model's order, and the bits of their weights.

TABLE_FLOATS(needle_laws, needle_laws_place);  // four rows a needle
TABLE_INTS(needle_facets, needle_facets_place);  // a, b, c, outward
STORED(needle_state, needle_state_place);
TABLE_INTS(needle_lists, needle_lists_place);
STORED(needle_places, needle_places_place);    // per node, at the step's start from the tip, m; along the axis
STORED(needle_motions, needle_motions_place);  // per node, m/s

uniform int needle;  // row of it among needles
uniform int number;  // step of the batch, from 1
uniform int facet_count, model_count;

const int header_rows = 4, hub_rows = 4;
// Rows to one, where terms are brought down to a total.
const int branch = 32;
// What the hole is at: nothing; whether the shaft has met the surface; a node there, where the tip is, on the way, at the
// exit.
const int done = 0, meets = 1, enters = 2, looks = 3, fills = 4, closes = 5;

int longest, most_around, needle_tool;  // nodes of a hole, particles of a node: room for
float needle_length, needle_radius, puncture, cutting, static_friction, kinetic_friction, surface_friction;  // N, N/m
float spread, first_reach;                                                                                  // m
float bending_stiffness;                                                                                    // N m^2

// Header.
int node_count;
bool punctured, through;
float slip;
int shaft_loads;
int full_step, unfinished_step;  // of the batch, the first; 0: none
int stage;
float left;   // m from the tip of the next node on the way made since the last one
float reach;  // m, of the next node's weights
float way;    // m from the tip to where the hole begins or ends
bool first;   // the hole had one node
vec3 aim;     // of the next node, from the tip, m
int known;    // nodes whose place and coupling were known when the step began

vec3 tip_high, tip_low;     // at the step's start, as a sum
vec3 axis_x, axis_y, axis;  // likewise; axis points to the hub

vec4 law_row(int row) {
  return fetch_load_vec4(needle_laws, needle_laws_place, 4 * needle + row);
}

vec4 state_row(int row) {
  return fetch_changing(needle_state, needle_state_place, row);
}

vec4 frame_row(int at, int row) {
  return fetch_load_vec4(tool_frames, tool_frames_place, 7 * (at * tool_count + needle_tool) + row);
}

void read_law() {
  vec4 room = law_row(0);
  vec4 size = law_row(1);
  vec4 limits = law_row(2);
  vec4 weights = law_row(3);
  longest = int(room.x);
  most_around = int(room.y);
  needle_tool = int(room.z);
  needle_length = size.x;
  needle_radius = size.y;
  puncture = limits.x;
  cutting = limits.y;
  static_friction = limits.z;
  kinetic_friction = limits.w;
  surface_friction = weights.x;
  spread = weights.y;
  first_reach = weights.z;
  bending_stiffness = weights.w;
}

void read_header() {
  vec4 hole = state_row(0);
  vec4 steps = state_row(1);
  vec4 work = state_row(2);
  vec4 next = state_row(3);
  node_count = int(hole.x);
  punctured = hole.y > 0.0;
  through = hole.z > 0.0;
  slip = hole.w;
  shaft_loads = int(steps.x);
  full_step = int(steps.y);
  unfinished_step = int(steps.z);
  stage = int(steps.w);
  left = work.x;
  reach = work.y;
  way = work.z;
  first = work.w > 0.0;
  aim = next.xyz;
  known = int(next.w);
}

void begin_needle() {
  read_law();
  read_header();
  vec4 x = frame_row(number - 1, 0);
  vec4 y = frame_row(number - 1, 1);
  vec4 z = frame_row(number - 1, 2);
  axis_x = x.xyz;
  axis_y = y.xyz;
  axis = z.xyz;
  tip_high = vec3(x.w, y.w, z.w);
  tip_low = frame_row(number - 1, 3).xyz;
}

vec4 header_row(int row) {
  if (row == 0) return vec4(float(node_count), punctured ? 1.0 : 0.0, through ? 1.0 : 0.0, slip);
  if (row == 1) return vec4(float(shaft_loads), float(full_step), float(unfinished_step), float(stage));
  if (row == 2) return vec4(left, reach, way, first ? 1.0 : 0.0);
  return vec4(aim, float(known));
}

int node_row(int k) {
  return header_rows + hub_rows + k;
}

int load_row(int k) {
  return node_row(longest) + k;
}

int around(int k) {
  return int(state_row(node_row(k)).x);
}

ivec2 list_entry(int k, int j) {
  return fetch_ivec2(needle_lists, needle_lists_place, k * most_around + j);
}

// Where particle i stands in node k's list; -1: it does not.
int entry_of(int k, int i) {
  int from = 0;
  int to = around(k) - 1;
  while (from <= to) {
    int middle = (from + to) >> 1;
    int at = list_entry(k, middle).x;
    if (at == i) return middle;
    if (at < i) {
      from = middle + 1;
    } else {
      to = middle - 1;
    }
  }
  return -1;
}

// Of a force on the shaft: m along it, N along the tool's x and y.
vec3 shaft_load(int k) {
  return state_row(load_row(k)).xyz;
}

ivec3 facet_corners(int t) {
  return fetch_load_ivec4(needle_facets, needle_facets_place, t).xyz;
}

vec3 displaced_by(int i) {
  return displaced(i);
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
