// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/delta_base.h. Needs vector3.glsl and, where AREA_EXPONENT is defined, delta_height.glsl.

struct DeltaBase {
  vec3 e1, e2;
  vec3 n;
  vec3 dn;
  vec3 change;
  float inverse_length;
#ifdef AREA_EXPONENT
  DeltaHeight height;
  float inverse_rest_length;
#endif
};

const float collapsed_sine_squared = 1e-12;

vec3 normal_change(vec3 n0, vec3 n, vec3 dw, float stretch, float inverse_length, float q0, float q) {
  return q < 0.25 * q0 ? n - n0 : inverse_length * (dw - stretch * n0);
}

void turn_base(vec3 w0, vec3 w, vec3 dw, float edges, float p, inout DeltaBase base) {
  float q0 = inner_product(w0, w0);
  float q = inner_product(w, w);
  float length0 = sqrt(q0);
  float length_now = sqrt(q);
  float inverse0 = 1.0 / length0;
  bool collapsed = q <= collapsed_sine_squared * edges;
  base.inverse_length = collapsed ? 0.0 : 1.0 / length_now;
  vec3 n0 = inverse0 * w0;
  base.n = base.inverse_length * w;
  float growth = inner_product(dw, w + w0);
  float stretch = growth * (1.0 / (length_now + length0));
  base.dn = normal_change(n0, base.n, dw, stretch, base.inverse_length, q0, q);
  base.dn = collapsed ? -n0 : base.dn;
  base.change = base.dn;
#ifdef AREA_EXPONENT
  base.inverse_rest_length = inverse0;
  base.height = delta_height(0.5 * growth * (inverse0 * inverse0), length_now * inverse0, p);
  base.change = base.height.value * base.dn + base.height.excess * n0;
#endif
}

DeltaBase delta_base_3d(vec3 E1, vec3 E2, vec3 d1, vec3 d2, float p) {
  DeltaBase base;
  base.e1 = E1 + d1;
  base.e2 = E2 + d2;
  vec3 dw = cross_product(d1, base.e2) + cross_product(E1, d2);
  float edges = inner_product(base.e1, base.e1) * inner_product(base.e2, base.e2);
  turn_base(cross_product(E1, E2), cross_product(base.e1, base.e2), dw, edges, p, base);
  return base;
}

DeltaBase delta_base_2d(vec3 E1, vec3 d1, float p) {
  DeltaBase base;
  base.e1 = E1 + d1;
  base.e2 = vec3(0.0);
  turn_base(vec3(-E1.y, E1.x, 0.0), vec3(-base.e1.y, base.e1.x, 0.0), vec3(-d1.y, d1.x, 0.0), 0.0, p, base);
  return base;
}

vec3 base_pull(DeltaBase base, vec3 to_a, vec3 d1, vec3 d2, float lambda_b, float lambda_c, float beta) {
  return to_a + lambda_b * d1 + lambda_c * d2 + beta * base.change;
}

vec3 height_slope(DeltaBase base, float beta, vec3 F) {
  float along = inner_product(base.n, F);
  vec3 across = F - along * base.n;
#ifdef AREA_EXPONENT
  vec3 G = (beta * base.height.value * base.inverse_length) * across;
  return G + (beta * base.height.slope * base.inverse_rest_length * along) * base.n;
#else
  return (beta * base.inverse_length) * across;
#endif
}

void base_reaction_3d(DeltaBase base, float lambda_b, float lambda_c, float beta, vec3 F, out vec3 on_a, out vec3 on_b,
                      out vec3 on_c) {
  vec3 G = height_slope(base, beta, F);
  on_b = -(lambda_b * F + cross_product(base.e2, G));
  on_c = -(lambda_c * F + cross_product(G, base.e1));
  on_a = -(F + on_b + on_c);
}

void base_reaction_2d(DeltaBase base, float lambda_b, float beta, vec3 F, out vec3 on_a, out vec3 on_b) {
  vec3 G = height_slope(base, beta, F);
  on_b = -(lambda_b * F + vec3(G.y, -G.x, 0.0));
  on_a = -(F + on_b);
}

float pull_energy(float k, vec3 pull) {
  return 0.5 * k * inner_product(pull, pull);
}
