// SPDX-License-Identifier: MIT
//
// Surfaces that touch, as in src/device/float_contacts.h, and what passes that are drawn write of them: contact_tables.glsl
// for textures. Needs dialect_fragment.glsl.

uniform int surface_count, body_count;  // of particles on surfaces, and of bodies

TABLE_INTS(surface, surface_place);              // row of the particle, body, bits of the mean edge around it
TABLE_FLOATS(surface_rest, surface_rest_place);  // two rows: X from the middle, m, as a sum
TABLE_INTS(triangle, triangle_place);            // corners: rows of `surface`; 2 * body + 1 where it has an inside
TABLE_FLOATS(triangle_law, triangle_law_place);  // longest edge, m

STORED(surface_moved, surface_moved_place);        // displacement, m; 1/m, 1/kg
STORED(surface_velocity, surface_velocity_place);  // m/s, before any contact; axes that take no pushes

// By meeting, surface row * body_count + body. A contact is one with a particle; none has fewer neighbours for it.
TABLE_INTS(meeting_who, meeting_who_place);      // the particle (-1: no contact), corners
STORED(meeting_nearest, meeting_nearest_place);  // shares of the corners in the nearest point, gap (m)
STORED(meeting_normal, meeting_normal_place);    // away from the triangle, edge (m)

// A place from the middle of the body.
vec3 about_place(int k) {
  return fetch_vec4(surface_rest, surface_rest_place, 2 * k).xyz +
         fetch_changing(surface_moved, surface_moved_place, k).xyz;
}

float triangle_edge(int t) {
  return fetch_vec4(triangle_law, triangle_law_place, t).x;
}

// From particle k to particle `other`, at rest.
vec3 rest_between(int k, int other) {
  vec3 high = fetch_vec4(surface_rest, surface_rest_place, 2 * other).xyz -
              fetch_vec4(surface_rest, surface_rest_place, 2 * k).xyz;
  vec3 low = fetch_vec4(surface_rest, surface_rest_place, 2 * other + 1).xyz -
             fetch_vec4(surface_rest, surface_rest_place, 2 * k + 1).xyz;
  return high + low;
}

// The same now, as exact as places are.
vec3 way_between(int k, int other) {
  return rest_between(k, other) + (fetch_changing(surface_moved, surface_moved_place, other).xyz -
                                   fetch_changing(surface_moved, surface_moved_place, k).xyz);
}

bool takes_pushes(int k) {
  return int(fetch_changing(surface_velocity, surface_velocity_place, k).w) != 7;
}

ivec4 who_meet(int m) {
  return fetch_ivec4(meeting_who, meeting_who_place, m);
}

int member(ivec4 who, int j) {
  return j == 0 ? who.x : j == 1 ? who.y : j == 2 ? who.z : who.w;
}
