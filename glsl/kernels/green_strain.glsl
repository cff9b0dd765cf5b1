// SPDX-License-Identifier: MIT
//
// Green's strain of F = I + H, and stresses of materials that dissipate. Needs columns.glsl.

// A symmetric matrix: xx, yy, zz, then yz, zx, xy.
struct Symmetric {
  real3 normal, shear;
};

// (H + H^T + H^T H) / 2
KERNEL Symmetric green_strain(Columns H) {
  real half_of = literal(0.5f);
  return Symmetric(real3(H.c0.x, H.c1.y, H.c2.z) +
                       half_of * real3(inner_product(H.c0, H.c0), inner_product(H.c1, H.c1), inner_product(H.c2, H.c2)),
                   half_of * (real3(H.c1.z + H.c2.y, H.c2.x + H.c0.z, H.c0.y + H.c1.x) +
                              real3(inner_product(H.c1, H.c2), inner_product(H.c2, H.c0), inner_product(H.c0, H.c1))));
}

KERNEL Symmetric symmetric_minus(Symmetric A, Symmetric B) {
  return Symmetric(A.normal - B.normal, A.shear - B.shear);
}

// A + s B
KERNEL Symmetric symmetric_plus(Symmetric A, real s, Symmetric B) {
  return Symmetric(A.normal + s * B.normal, A.shear + s * B.shear);
}

// 2 mu E + lambda tr(E) I
KERNEL Symmetric isotropic_stress(Symmetric E, real two_mu, real lambda) {
  real pressure = lambda * (E.normal.x + E.normal.y + E.normal.z);
  return Symmetric(two_mu * E.normal + real3(pressure, pressure, pressure), two_mu * E.shear);
}

// F times the second Piola stress: the first.
KERNEL Columns first_piola(Columns H, Symmetric second) {
  real3 s0 = real3(second.normal.x, second.shear.z, second.shear.y);
  real3 s1 = real3(second.shear.z, second.normal.y, second.shear.x);
  real3 s2 = real3(second.shear.y, second.shear.x, second.normal.z);
  return Columns(s0 + times(H, s0), s1 + times(H, s1), s2 + times(H, s2));
}
