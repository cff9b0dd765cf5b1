// SPDX-License-Identifier: MIT
//
// The energy of StrainEnergy::neo_hookean (topology.h) at F = I + H: its derivative by F, exactly 0 at H = 0. Notation of
// src/elastic/energy_density.h. While u is at least 0.6, with I1 = |F|^2,
//   P = mu J^(-2/3) [H - (cof(F) - I) + (1 - I1 / (3 J)) cof(F)] + K U'(J) cof(F)
// where 3 J - I1 = tr(H) + 3 (minors + det) - |H|^2, so that nothing is lost near rest. Needs columns.glsl, volume.glsl.

struct Invariants {
  real J;       // det F
  real I1, I2;  // |F|^2, |cof(F)|^2
};

KERNEL Invariants invariants_of(Columns H, Change change) {
  real of_strain = change.trace + change.trace + squared_norm(H);
  return Invariants(literal(1.0f) + volume_change(change), literal(3.0f) + of_strain,
                    squared_norm(plus_identity(change.cof)));
}

// Not negative while u >= 0.6.
KERNEL real room_within_the_law(Invariants of) {
  real norm = literal(1.0f) + literal(0.33333334f) * of.I1;
  real least = (literal(0.03f) * of.I2) * (norm * norm);
  return select(of.J > literal(0.0f), of.J * of.J, literal(0.0f)) - least;
}

// The square of the condition number |F| |F^-1| by Frobenius' norm, over its value 9 at rest; |F|^2 |cof(F)|^2 / 9 where
// J > 1. How much the frequencies can have risen follows from it (docs/theory/physics.md). 1e6 beyond the
// law, 2e6 where F is inverted.
KERNEL real squared_condition(Columns H, Change change) {
  real one = literal(1.0f);
  Invariants of = invariants_of(H, change);
  real least = select(of.J > one, one, of.J * of.J);
  real condition = (of.I1 * of.I2) * (literal(0.11111111f) / least);
  return select(room_within_the_law(of) < literal(0.0f), select(of.J > literal(0.0f), literal(1e6f), literal(2e6f)), condition);
}

// Where the far energy has a share w.
struct FarShare {
  real share, slope;                   // w and dw/du
  real d, u, within;                   // within: 1 / (1 + I1 / 3)
  real inverse, inverse_square;        // of |cof(F)|; 0 where d has no direction
};

// No product has more than four factors between sums and selections, and one of four is that of two products.
KERNEL FarShare far_share(Invariants of) {
  real zero = literal(0.0f);
  real one = literal(1.0f);
  real third = literal(0.33333334f);
  real root_of_three = literal(1.7320508f);
  // Where two stretches are nothing beside the third, d has no direction left.
  real least = literal(1e-12f) * (of.I1 * of.I1) + literal(1e-30f);
  real some = select(of.I2 > least, of.I2, one);
  real inverse = select(of.I2 > least, inverse_root(some), zero);
  real inverse_square = select(of.I2 > least, one / some, zero);
  real d = select(of.I2 > least, root_of_three * (of.J * inverse), zero);
  real within = one / (one + third * of.I1);
  real u = select(of.J > zero, literal(2.0f) * (d * within), zero);  // where it is below 0.2, no matter what it is
  real t = literal(1.5f) - literal(2.5f) * u;
  t = select(room_within_the_law(of) < zero, select(t < one, t, one), zero);
  t = select(t > zero, t, zero);
  real w = (t * t) * (literal(3.0f) - literal(2.0f) * t);
  real slope = select(t < one, literal(-15.0f) * (t * (one - t)), zero);
  return FarShare(w, slope, d, u, within, inverse, inverse_square);
}

// The far energy over mu, less the near one, which is (J^(-2/3) I1 - 3) / 2.
KERNEL real rise_to_far(Invariants of, FarShare at, real g) {
  return (literal(0.5f) * of.I1 - literal(2.5f) * at.d + literal(1.5f)) - literal(0.5f) * (g * of.I1 - literal(3.0f));
}

// P over mu, of which `near` is the near energy's, and the far energy's has the weight `far`; `rise`: from the near
// energy to the far one.
KERNEL Columns passed_stress(Columns near, Columns H, Change change, FarShare at, real far, real rise) {
  real one = literal(1.0f);
  real third = literal(0.33333334f);
  real root_of_three = literal(1.7320508f);
  Columns F = plus_identity(H);
  Columns cof = plus_identity(change.cof);
  real half_by_u = (at.slope * rise) * at.within;
  real by_u = half_by_u + half_by_u;
  // grad u = 2 within grad d - 2/3 u within F, grad d = inverse root_of_three cof - inverse^2 d A, A = grad I2 / 2
  Columns A = Columns(cross_product(cof.c1, F.c2) + cross_product(F.c1, cof.c2),
                      cross_product(cof.c2, F.c0) + cross_product(F.c2, cof.c0),
                      cross_product(cof.c0, F.c1) + cross_product(F.c0, cof.c1));
  real by_d = by_u - literal(2.5f) * far;
  Columns P = plus(scaled(one - at.share, near), scaled(far - (third * by_u) * at.u, F));
  Columns D =
      minus(scaled(by_d * at.inverse, scaled(root_of_three, cof)), scaled(by_d * at.inverse_square, scaled(at.d, A)));
  return plus(P, D);
}

struct Near {
  real inverse, root, g;  // 1 / J, J^(-1/3), J^(-2/3); 1 where J is not positive
  Columns P;              // J^(-2/3) [...]
};

KERNEL Near near_stress(Columns H, Change change, Invariants of) {
  real tiny = literal(1e-9f);
  real base = select(of.J > tiny, of.J, literal(1.0f));
  real root = inverse_cube_root(base);
  real g = select(of.J > tiny, root * root, literal(1.0f));
  real inverse = literal(1.0f) / base;
  real excess = literal(3.0f) * (change.minors + change.determinant) + (change.trace - squared_norm(H));
  real along = (literal(0.33333334f) * excess) * inverse;
  return Near(inverse, root, g, scaled(g, plus(minus(H, change.cof), scaled(along, plus_identity(change.cof)))));
}

KERNEL Columns neo_hookean_stress(Columns H, Change change, real mu, real K) {
  Invariants of = invariants_of(H, change);
  Near near = near_stress(H, change, of);
  Columns P = near.P;
  if (any_below(room_within_the_law(of), literal(0.0f))) {
    FarShare at = far_share(of);
    P = passed_stress(P, H, change, at, at.share, rise_to_far(of, at, near.g));
  }
  return plus(scaled(mu, P), volume_stress(change, K));
}
