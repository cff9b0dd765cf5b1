// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/delta_spring.h. Needs vector3.glsl.

float spring_stretch(vec3 R, vec3 d, vec3 r, float length_now) {
  float both = length_now + sqrt(inner_product(R, R));
  return both > 0.0 ? inner_product(d, R + r) * (1.0 / both) : 0.0;
}

vec3 spring_force(vec3 R, vec3 d, float k) {
  vec3 r = R + d;
  float length_now = sqrt(inner_product(r, r));
  float tension = k * spring_stretch(R, d, r, length_now) * (1.0 / length_now);
  return length_now > 0.0 ? tension * r : vec3(0.0);
}

float spring_energy(vec3 R, vec3 d, float k) {
  vec3 r = R + d;
  float stretch = spring_stretch(R, d, r, sqrt(inner_product(r, r)));
  return 0.5 * k * stretch * stretch;
}
