// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/delta_cell.h. Needs vector3.glsl, delta_base.glsl without AREA_EXPONENT, delta_volume.glsl.

struct Columns {
  vec3 c0, c1, c2;
};

vec3 times(Columns H, vec3 t) {
  return t.x * H.c0 + t.y * H.c1 + t.z * H.c2;
}

void add_outer(inout Columns A, vec3 a, vec3 b) {
  A.c0 += b.x * a;
  A.c1 += b.y * a;
  A.c2 += b.z * a;
}

struct CellPull {
  vec3 f1, f2, n, r;
  float inverse_length;
};

CellPull cell_pull(Columns H, vec3 m, vec3 t1, vec3 t2) {
  vec3 d1 = times(H, t1);
  vec3 d2 = times(H, t2);
  DeltaBase base;
  base.e1 = t1 + d1;
  base.e2 = t2 + d2;
  vec3 dw = cross_product(d1, base.e2) + cross_product(t1, d2);
  float edges = inner_product(base.e1, base.e1) * inner_product(base.e2, base.e2);
  turn_base(m, cross_product(base.e1, base.e2), dw, edges, 0.0, base);
  return CellPull(base.e1, base.e2, base.n, base.dn - times(H, m), base.inverse_length);
}

void add_direction(Columns H, vec3 m, vec3 t1, vec3 t2, float weight, inout Columns P) {
  CellPull d = cell_pull(H, m, t1, t2);
  add_outer(P, -(weight * d.r), m);
  vec3 G = (weight * d.inverse_length) * (d.r - inner_product(d.n, d.r) * d.n);
  add_outer(P, cross_product(d.f2, G), t1);
  add_outer(P, cross_product(G, d.f1), t2);
}

float direction_energy(Columns H, vec3 m, vec3 t1, vec3 t2, float weight) {
  vec3 r = cell_pull(H, m, t1, t2).r;
  return 0.5 * weight * inner_product(r, r);
}

const int direction_count = 7;

// m, t1, t2 and the weight of direction number i.
void cell_direction(int i, out vec3 m, out vec3 t1, out vec3 t2, out float weight) {
  const float d = 0.57735027;
  const float s = 0.70710678;
  const float a = 0.8164966;
  const float b = 0.4082483;
  weight = i < 4 ? 0.15 : 0.13333334;
  if (i == 0) {
    m = vec3(d, d, d);
    t1 = vec3(0.0, -s, s);
    t2 = vec3(a, -b, -b);
  } else if (i == 1) {
    m = vec3(-d, d, d);
    t1 = vec3(0.0, -s, s);
    t2 = vec3(a, b, b);
  } else if (i == 2) {
    m = vec3(d, -d, d);
    t1 = vec3(0.0, -s, -s);
    t2 = vec3(a, b, -b);
  } else if (i == 3) {
    m = vec3(d, d, -d);
    t1 = vec3(0.0, s, s);
    t2 = vec3(a, -b, b);
  } else if (i == 4) {
    m = vec3(1.0, 0.0, 0.0);
    t1 = vec3(0.0, 0.0, -1.0);
    t2 = vec3(0.0, 1.0, 0.0);
  } else if (i == 5) {
    m = vec3(0.0, 1.0, 0.0);
    t1 = vec3(0.0, 0.0, 1.0);
    t2 = vec3(1.0, 0.0, 0.0);
  } else {
    m = vec3(0.0, 0.0, 1.0);
    t1 = vec3(0.0, -1.0, 0.0);
    t2 = vec3(1.0, 0.0, 0.0);
  }
}

float determinant_change(Columns H) {
  vec3 F1 = vec3(H.c1.x, 1.0 + H.c1.y, H.c1.z);
  vec3 F2 = vec3(H.c2.x, H.c2.y, 1.0 + H.c2.z);
  return inner_product(H.c0, cross_product(F1, F2)) + (H.c1.y * F2.z - H.c1.z * F2.y) + H.c2.z;
}

Columns cell_stress(Columns H, float shape_stiffness, float volume_stiffness) {
  Columns P = Columns(vec3(0.0), vec3(0.0), vec3(0.0));
  for (int i = 0; i < direction_count; ++i) {
    vec3 m, t1, t2;
    float weight;
    cell_direction(i, m, t1, t2, weight);
    add_direction(H, m, t1, t2, weight, P);
  }
  vec3 F0 = vec3(1.0 + H.c0.x, H.c0.y, H.c0.z);
  vec3 F1 = vec3(H.c1.x, 1.0 + H.c1.y, H.c1.z);
  vec3 F2 = vec3(H.c2.x, H.c2.y, 1.0 + H.c2.z);
  float q = volume_stiffness * volume_pressure(determinant_change(H));
  return Columns(shape_stiffness * P.c0 + q * cross_product(F1, F2), shape_stiffness * P.c1 + q * cross_product(F2, F0),
                 shape_stiffness * P.c2 + q * cross_product(F0, F1));
}

float cell_energy(Columns H, float shape_stiffness, float volume_stiffness) {
  float sum = 0.0;
  for (int i = 0; i < direction_count; ++i) {
    vec3 m, t1, t2;
    float weight;
    cell_direction(i, m, t1, t2, weight);
    sum = sum + direction_energy(H, m, t1, t2, weight);
  }
  return shape_stiffness * sum + volume_stiffness * volume_energy_density(determinant_change(H));
}
