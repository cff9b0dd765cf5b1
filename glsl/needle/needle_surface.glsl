// SPDX-License-Identifier: MIT
//
// Where a line meets a triangle of the body's surface. Needs needle_tables.glsl.

// A way along a line of the mesh must not pass between two triangles by rounding: by this share of a side, and of how
// far away it is, triangles are taken to be larger.
const float overlap = 5e-7;

vec3 edge_between(int i, int j) {
  vec3 high = fetch_load_vec4(tool_rest, tool_rest_place, 2 * j).xyz -
              fetch_load_vec4(tool_rest, tool_rest_place, 2 * i).xyz;
  vec3 low = fetch_load_vec4(tool_rest, tool_rest_place, 2 * j + 1).xyz -
             fetch_load_vec4(tool_rest, tool_rest_place, 2 * i + 1).xyz;
  return (high + low) + (displaced_by(j) - displaced_by(i));
}

// Way to triangle t, and > 0 where its outside looks along the direction; the way is negative where there is none. (T.
// Moeller, B. Trumbore, J. Graphics Tools 2 (1997) 21-28.)
vec2 way_to(int t, vec3 from, vec3 direction) {
  ivec3 corners = facet_corners(t);
  int i = corners.x;
  vec3 e1 = edge_between(i, corners.y);
  vec3 e2 = edge_between(i, corners.z);
  vec3 p = cross_product(direction, e2);
  float determinant = inner_product(e1, p);
  if (determinant == 0.0) return vec2(-1.0, 0.0);
  vec3 s = from - place_of(i);
  vec3 q = cross_product(s, e1);
  float inverse = 1.0 / determinant;
  float u = inverse * inner_product(s, p);
  float v = inverse * inner_product(direction, q);
  float side = min(inner_product(e1, e1), inner_product(e2, e2));
  float more = overlap * (1.0 + sqrt(inner_product(s, s) / side));
  if (!(u >= -more && v >= -more && u + v <= 1.0 + more)) return vec2(-1.0, 0.0);
  return vec2(inverse * inner_product(e2, q), -determinant);
}
