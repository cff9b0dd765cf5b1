// SPDX-License-Identifier: MIT
//
// What needle_coupling_pass.glsl wrote. Needs needle_state.glsl.

STORED(needle_coupling, needle_coupling_place);

// 1/kg along the axes, and of one number for all of them.
vec4 coupling(int k, int other) {
  return fetch_changing(needle_coupling, needle_coupling_place, k * longest + other);
}
