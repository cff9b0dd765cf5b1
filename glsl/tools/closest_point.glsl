// SPDX-License-Identifier: MIT
//
// Twin of src/model/closed_surface.h, for p = 0: shares of a, b, c in their triangle's point nearest to the origin. Needs
// kernel_language.glsl.

vec3 closest_point(vec3 a, vec3 b, vec3 c) {
  vec3 ab = b - a;
  vec3 ac = c - a;
  float d1 = -inner_product(ab, a);
  float d2 = -inner_product(ac, a);
  if (d1 <= 0.0 && d2 <= 0.0) return vec3(1.0, 0.0, 0.0);
  float d3 = -inner_product(ab, b);
  float d4 = -inner_product(ac, b);
  if (d3 >= 0.0 && d4 <= d3) return vec3(0.0, 1.0, 0.0);
  float d5 = -inner_product(ab, c);
  float d6 = -inner_product(ac, c);
  if (d6 >= 0.0 && d5 <= d6) return vec3(0.0, 0.0, 1.0);
  float over_ab = d1 * d4 - d3 * d2;
  if (over_ab <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    float t = d1 / (d1 - d3);
    return vec3(1.0 - t, t, 0.0);
  }
  float over_ac = d5 * d2 - d1 * d6;
  if (over_ac <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    float t = d2 / (d2 - d6);
    return vec3(1.0 - t, 0.0, t);
  }
  float over_bc = d3 * d6 - d5 * d4;
  if (over_bc <= 0.0 && d4 >= d3 && d5 >= d6) {
    float t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return vec3(0.0, 1.0 - t, t);
  }
  float whole = over_ab + over_ac + over_bc;
  if (!(whole > 0.0)) return vec3(1.0, 0.0, 0.0);
  float v = over_ac / whole;
  float w = over_ab / whole;
  return vec3(1.0 - v - w, v, w);
}
