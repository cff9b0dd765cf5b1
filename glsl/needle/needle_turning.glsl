// SPDX-License-Identifier: MIT
//
// The part of friction around a shaft that turns: a torque on the particles around a node. Needs needle_motion.glsl.

// Which way it pushes particle i, m.
vec3 turning_of(int i) {
  int axes = int(fetch_load_vec4(free_velocity, free_velocity_place, i).w);
  vec3 around_axis = cross_product(end_axis, across(place_of(i) - gone));
  return vec3((axes & 1) != 0 ? 0.0 : around_axis.x, (axes & 2) != 0 ? 0.0 : around_axis.y,
              (axes & 4) != 0 ? 0.0 : around_axis.z);
}
