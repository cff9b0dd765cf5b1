// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/delta_volume.h. Needs vector3.glsl.

float volume_pressure(float change) {
#ifdef BOUNDED_VOLUME
  float x = change * 2.5;
  return change * (1.0 / sqrt(1.0 + x * x));
#else
  return change;
#endif
}

float volume_energy_density(float change) {
#ifdef BOUNDED_VOLUME
  float x = change * 2.5;
  return change * change * (1.0 / (1.0 + sqrt(1.0 + x * x)));
#else
  return 0.5 * change * change;
#endif
}

float tetrahedron_change(vec3 E1, vec3 E2, vec3 E3, vec3 d1, vec3 d2, vec3 d3, float inverse_rest) {
  vec3 e2 = E2 + d2;
  vec3 e3 = E3 + d3;
  vec3 dw = cross_product(d1, e2) + cross_product(E1, d2);
  return (inner_product(dw, e3) + inner_product(cross_product(E1, E2), d3)) * inverse_rest;
}

void tetrahedron_volume_forces(vec3 E1, vec3 E2, vec3 E3, vec3 d1, vec3 d2, vec3 d3, float inverse_rest,
                               float stiffness, out vec3 on_a, out vec3 on_b, out vec3 on_c, out vec3 on_d) {
  vec3 e1 = E1 + d1;
  vec3 e2 = E2 + d2;
  vec3 e3 = E3 + d3;
  float change = tetrahedron_change(E1, E2, E3, d1, d2, d3, inverse_rest);
  float q = -(stiffness * volume_pressure(change) * inverse_rest);
  on_b = q * cross_product(e2, e3);
  on_c = q * cross_product(e3, e1);
  on_d = q * cross_product(e1, e2);
  on_a = -(on_b + on_c + on_d);
}

float triangle_change(vec3 E1, vec3 E2, vec3 d1, vec3 d2, float inverse_rest) {
  vec3 e2 = E2 + d2;
  return ((d1.x * e2.y - d1.y * e2.x) + (E1.x * d2.y - E1.y * d2.x)) * inverse_rest;
}

void triangle_area_forces(vec3 E1, vec3 E2, vec3 d1, vec3 d2, float inverse_rest, float stiffness, out vec3 on_a,
                          out vec3 on_b, out vec3 on_c) {
  vec3 e1 = E1 + d1;
  vec3 e2 = E2 + d2;
  float q = -(stiffness * volume_pressure(triangle_change(E1, E2, d1, d2, inverse_rest)) * inverse_rest);
  on_b = q * vec3(e2.y, -e2.x, 0.0);
  on_c = q * vec3(-e1.y, e1.x, 0.0);
  on_a = -(on_b + on_c);
}
