// SPDX-License-Identifier: MIT
//
// F_i, N, as the attractor pass wrote it.

vec3 force_of(int i) {
  return fetch_changing(force, force_place, i).xyz;
}
