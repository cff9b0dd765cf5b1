// SPDX-License-Identifier: MIT
//
// Per particle, linear momentum, kg m/s, and angular momentum about the rest shape's middle, kg m^2/s. Needs tables.glsl
// and kernel_language.glsl.

RESULT(0, vec4, linear);
RESULT(1, vec4, angular);

void momentum_row(int i) {
  vec3 v = fetch_changing(velocity, velocity_place, i).xyz;
  vec3 momentum = fetch_vec4(particle, particle_place, i).z * v;
  linear = vec4(momentum, 0.0);
  angular = vec4(cross_product(fetch_load_vec4(rest, rest_place, i).xyz + displaced(i), momentum), 0.0);
}

PASS_MAIN(momentum_row)
