// SPDX-License-Identifier: MIT
//
// StrainEnergy::neo_hookean at F = I + H, of mu and K. Needs columns.glsl, volume.glsl. With g(J) = J^(-2/3), b = max(J, 0.7),
// d = b - J, which is 0 but for what is squashed to less than that, and I1 = tr(F^T F):
//   P = mu g(b) [H - (cof(F) - I) + (1 - I1 / (3 b)) cof(F) + 2/3 d/b F] + (K U'(J) - 6.2 mu d) cof(F)
// and 3 b - I1 = 3 d + tr(H) + 3 (minors + det) - |H|^2, so that nothing is lost near rest.

KERNEL_CONSTANT int energy_constants = 2;

struct Dilatation {
  real change;  // J - 1
  real base;    // b
  real below;   // d
  real root;    // b^(-1/3)
};

KERNEL Dilatation dilatation(Change change) {
  real e = volume_change(change);
  real least = literal(0.7f);
  real J = literal(1.0f) + e;
  real base = select(J > least, J, least);
  return Dilatation(e, base, select(J > least, literal(0.0f), literal(-0.3f) - e), inverse_cube_root(base));
}

KERNEL Columns energy_stress(Columns H, real p[energy_constants]) {
  Change change = change_of(H);
  Dilatation of = dilatation(change);
  Columns cof = plus_identity(change.cof);
  real three = literal(3.0f);
  real share = literal(1.0f) / of.base;
  real excess = three * (of.below + change.minors + change.determinant) + (change.trace - squared_norm(H));
  Columns P = plus(minus(H, change.cof), scaled(literal(0.33333334f) * excess * share, cof));
  P = plus(P, scaled(literal(0.6666667f) * of.below * share, plus_identity(H)));
  return plus(scaled(p[0] * (of.root * of.root), P), scaled(p[1] * volume_pressure(of.change) - literal(6.2f) * p[0] * of.below, cof));
}
