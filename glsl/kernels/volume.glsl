// SPDX-License-Identifier: MIT
//
// Volume energies, as a function of J - 1, and those of a tetrahedron (triangle in 2-D). E are edges at rest, d
// differences of displacements to the first vertex, e = E + d:
//   e1 x e2 . e3 - E1 x E2 . E3 = (d1 x e2 + E1 x d2) . e3 + (E1 x E2) . d3
// so that J - 1 is exactly 0 at rest. `bounded_volume`: VolumeLaw::bounded. Needs columns.glsl.

// U'(J)
KERNEL real volume_pressure(real change) {
  if (!bounded_volume) return change;
  real most = literal(0.5f);
  real above = select(change < -most, -most, change);
  return select(above > most, most, above);
}

// The derivative of stiffness * U(det F) by F.
KERNEL Columns volume_stress(Change change, real stiffness) {
  return scaled(stiffness * volume_pressure(volume_change(change)), plus_identity(change.cof));
}

// J - 1; inverse_rest: 1 / (6 V)
KERNEL real tetrahedron_change(real3 E1, real3 E2, real3 E3, real3 d1, real3 d2, real3 d3, real inverse_rest) {
  real3 e2 = E2 + d2;
  real3 e3 = E3 + d3;
  real3 dw = cross_product(d1, e2) + cross_product(E1, d2);
  return (inner_product(dw, e3) + inner_product(cross_product(E1, E2), d3)) * inverse_rest;
}

KERNEL void tetrahedron_volume_forces(real3 E1, real3 E2, real3 E3, real3 d1, real3 d2, real3 d3, real inverse_rest,
                                      real stiffness, OUT(real3) on_a, OUT(real3) on_b, OUT(real3) on_c,
                                      OUT(real3) on_d) {
  real3 e1 = E1 + d1;
  real3 e2 = E2 + d2;
  real3 e3 = E3 + d3;
  real change = tetrahedron_change(E1, E2, E3, d1, d2, d3, inverse_rest);
  real q = -(stiffness * volume_pressure(change) * inverse_rest);
  on_b = q * cross_product(e2, e3);
  on_c = q * cross_product(e3, e1);
  on_d = q * cross_product(e1, e2);
  on_a = -(on_b + on_c + on_d);
}

// inverse_rest: 1 / (2 A)
KERNEL real triangle_change(real3 E1, real3 E2, real3 d1, real3 d2, real inverse_rest) {
  real3 e2 = E2 + d2;
  return ((d1.x * e2.y - d1.y * e2.x) + (E1.x * d2.y - E1.y * d2.x)) * inverse_rest;
}

KERNEL void triangle_area_forces(real3 E1, real3 E2, real3 d1, real3 d2, real inverse_rest, real stiffness,
                                 OUT(real3) on_a, OUT(real3) on_b, OUT(real3) on_c) {
  real3 e1 = E1 + d1;
  real3 e2 = E2 + d2;
  real zero = literal(0.0f);
  real q = -(stiffness * volume_pressure(triangle_change(E1, E2, d1, d2, inverse_rest)) * inverse_rest);
  on_b = q * real3(e2.y, -e2.x, zero);
  on_c = q * real3(-e1.y, e1.x, zero);
  on_a = -(on_b + on_c);
}
