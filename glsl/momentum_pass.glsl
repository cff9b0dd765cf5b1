// SPDX-License-Identifier: MIT
//
// Per particle, linear momentum, kg m/s, and angular momentum about the rest shape's middle, kg m^2/s. Needs
// displacement.glsl and vector3.glsl.

uniform sampler2D velocity;
uniform int velocity_log2;
uniform sampler2D particle;  // 1/m, k_i, m
uniform int particle_log2;
uniform sampler2D rest;  // X_i from the middle, m
uniform int rest_log2;

layout(location = 0) out vec4 linear;
invariant linear;
layout(location = 1) out vec4 angular;
invariant angular;

void main() {
  int i = own_row();
  if (i >= row_count) discard;
  vec3 momentum = fetch(particle, particle_log2, i).z * fetch(velocity, velocity_log2, i).xyz;
  linear = vec4(momentum, 0.0);
  angular = vec4(cross_product(fetch(rest, rest_log2, i).xyz + displaced(i), momentum), 0.0);
}
