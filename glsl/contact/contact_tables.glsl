// SPDX-License-Identifier: MIT
//
// Surfaces that touch, as in src/device/float_scene.h, and what the passes of a step write of them, among the rows of the
// loads. Single integers are seen through a second block over the same memory; in no dispatch is anything seen through
// both. Needs dialect_compute.glsl.

layout(std430, binding = 1) SEEN_BY_ALL buffer LoadWords {
  int load_words[];
};

uniform int surface_count, triangle_count, body_count;  // of particles on surfaces, and of bodies
uniform int bucket_count;                               // a power of two

TABLE_INTS(surface, surface_place);                    // place of the particle, body, bits of the mean edge around it
TABLE_FLOATS(surface_rest, surface_rest_place);        // two rows: X from the middle, m, as a sum
TABLE_INTS(triangle, triangle_place);                  // corners: rows of `surface`; 2 * body + 1 where it has an inside
TABLE_FLOATS(triangle_law, triangle_law_place);        // longest edge, m

TABLE_FLOATS(contact_range, contact_range_place);      // one row: margin, reach, m; 1 / side of a cell, 1/m
TABLE_FLOATS(surface_moved, surface_moved_place);      // displacement, m; 1/m, 1/kg
TABLE_FLOATS(surface_velocity, surface_velocity_place);  // m/s, with the impulses so far; axes that take none
TABLE_FLOATS(surface_push, surface_push_place);        // N s, sum of the impulses
TABLE_FLOATS(triangle_ball, triangle_ball_place);      // middle (from that of the body), radius about it, m
TABLE_INTS(meeting, meeting_place);  // four rows for each particle and body: the particle (-1: none), corners; their
                                     // shares in the nearest point, gap (m); normal away from the triangle, edge (m);
                                     // N s so far: across the normal, along it

// Words: lists per bucket and per particle in compressed rows, whose first[k] and first[k + 1] bound those of k.
uniform int bucket_first, bucket_list;  // triangles, in ascending order
uniform int queue_first, queue_list;    // 4 * contact + its corner (0: its particle), in ascending order
uniform int live_list;                  // meeting of a contact: those that there are, in ascending order
uniform int live_count;                 // one word; the next one counts what press has done
uniform int turn_list, ticket_list;     // of contact_press_kernel.glsl

vec4 float_row(int row) {
  return intBitsToFloat(load_rows[row]);
}

void store_row(int row, vec4 value) {
  PRECISE vec4 stored = value;
  load_rows[row] = floatBitsToInt(stored);
}

int meeting_row(int particle, int body) {
  return meeting_place + 4 * (particle * body_count + body);
}

// A place from the middle of the body: good enough for cells.
vec3 about_place(int k) {
  return float_row(surface_rest_place + 2 * k).xyz + float_row(surface_moved_place + k).xyz;
}

float triangle_edge(int t) {
  return float_row(triangle_law_place + t).x;
}

// From particle k to particle `other`, at rest.
vec3 rest_between(int k, int other) {
  vec3 high = float_row(surface_rest_place + 2 * other).xyz - float_row(surface_rest_place + 2 * k).xyz;
  vec3 low = float_row(surface_rest_place + 2 * other + 1).xyz - float_row(surface_rest_place + 2 * k + 1).xyz;
  return high + low;
}

// The same now, as exact as places are.
vec3 way_between(int k, int other) {
  return rest_between(k, other) + (float_row(surface_moved_place + other).xyz - float_row(surface_moved_place + k).xyz);
}

int cell_along(float q) {
  return q > -1e9 && q < 1e9 ? int(floor(q)) : 1000000000;  // who runs away is found out elsewhere
}

ivec3 cell_at(vec3 x, float inverse_side) {
  return ivec3(cell_along(x.x * inverse_side), cell_along(x.y * inverse_side), cell_along(x.z * inverse_side));
}

int bucket_at(ivec3 cell) {
  uint h = uint(cell.x) * 0x9e3779b9u;
  h = ((h ^ (h >> 15)) ^ uint(cell.y)) * 0x85ebca6bu;
  h = ((h ^ (h >> 13)) ^ uint(cell.z)) * 0xc2b2ae35u;
  return int((h ^ (h >> 16)) & uint(bucket_count - 1));
}
