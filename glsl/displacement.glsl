// SPDX-License-Identifier: MIT
//
// Where the particles are: u_i = x_i - X_i, m. Needs fetch.glsl.

uniform sampler2D displacement;
uniform int displacement_log2;

vec3 displaced(int i) {
  return fetch(displacement, displacement_log2, i).xyz;
}
