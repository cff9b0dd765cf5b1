// SPDX-License-Identifier: MIT
//
// StrainEnergy::stiffening (topology.h) at F = I + H, of mu, K, k, b, c, d: its derivative by F, exactly 0 at H = 0. X, Y
// as there; D = Y - X. Of both by_X / 2 and by_Y / 2 nothing is lost near rest:
//   by_Y / 2 = J^(-4/3) [A - 2 cof(F) + 2 (1 - I2 / (3 J)) cof(F)],  A = grad(I2) / 2
// where 3 J - I2 = -tr(H) + minors + 3 det - |cof(F) - I|^2. Needs columns.glsl, volume.glsl, neo_hookean.glsl.

KERNEL_CONSTANT int energy_constants = 6;

// e^t for t from 0 to 4, to a few parts in 10^6: the sixteenth power of a Taylor polynomial.
KERNEL real exponential(real t) {
  real one = literal(1.0f);
  real z = literal(0.0625f) * t;
  real low = literal(0.041666668f) + z * (literal(0.008333334f) + literal(0.0013888889f) * z);
  real e = one + z * (one + z * (literal(0.5f) + z * (literal(0.16666667f) + z * low)));
  e = e * e;
  e = e * e;
  e = e * e;
  return e * e;
}

// b X, of which the exponential is taken.
KERNEL real exponent_of(real X, real p[energy_constants]) {
  real t = p[3] * X;
  t = select(t > literal(0.0f), t, literal(0.0f));
  return select(t < literal(4.0f), t, literal(4.0f));
}

// dpsi/dX over its value at rest, without the last term.
KERNEL real growth_of(real X, real p[energy_constants]) {
  return literal(1.0f) + p[2] * (exponential(exponent_of(X, p)) - literal(1.0f));
}

// X and Y - X of the near energy.
struct Shape {
  real X, D;
};

KERNEL Shape shape_of(Columns H, Change change, Invariants of, Near near) {
  real one = literal(1.0f);
  // J^(-2/3) - 1
  real less = (volume_change(change) * near.inverse) * ((near.root + one) * (one / (near.g + near.root + one)));
  less = select(of.J > literal(1e-9f), -less, literal(0.0f));
  real X = less * of.I1 + (change.trace + change.trace + squared_norm(H));
  real rise = literal(4.0f) * change.trace + literal(2.0f) * change.minors + squared_norm(change.cof);  // I2 - 3
  real Y = (less * (near.g + one)) * of.I2 + rise;
  return Shape(X, Y - X);
}

// by_Y / 2
KERNEL Columns second_stress(Columns H, Change change, Near near) {
  Columns C = change.cof;
  Columns F = plus_identity(H);
  // A = 2 I + C - cof(H) + `both`: cof(F) = I + C, F = I + H, and A is made of cross products of their columns.
  Columns both = Columns(cross_product(C.c1, F.c2) + cross_product(F.c1, C.c2),
                         cross_product(C.c2, F.c0) + cross_product(F.c2, C.c0),
                         cross_product(C.c0, F.c1) + cross_product(F.c0, C.c1));
  real excess = (literal(3.0f) * change.determinant + change.minors) - (change.trace + squared_norm(C));
  real along = (literal(0.6666667f) * excess) * near.inverse;
  Columns A = minus(both, plus(C, cofactor(H)));
  return scaled(near.g * near.g, plus(A, scaled(along, plus_identity(C))));
}

KERNEL Columns energy_stress(Columns H, real p[energy_constants]) {
  real zero = literal(0.0f);
  real one = literal(1.0f);
  Change change = change_of(H);
  Invariants of = invariants_of(H, change);
  Near near = near_stress(H, change, of);
  Shape shape = shape_of(H, change, of, near);
  real within = one / (one + p[5] * select(shape.X > zero, shape.X, zero));
  real second = p[4] * within;
  real half_energy = literal(0.5f) * (second * shape.D);
  Columns P = minus(scaled(second, minus(second_stress(H, change, near), near.P)),
                    scaled((p[5] * within) * (half_energy + half_energy), near.P));
  if (any_below(room_within_the_law(of), zero)) {
    FarShare at = far_share(of);
    real rise = rise_to_far(of, at, near.g);
    real growth = growth_of(shape.X + literal(2.0f) * (at.share * rise), p);
    // Where nothing of the near energy is left, its numbers may be beyond all bounds.
    real3 none = real3(zero, zero, zero);
    P = Columns(select(at.share < one, P.c0, none), select(at.share < one, P.c1, none),
                select(at.share < one, P.c2, none));
    half_energy = select(at.share < one, half_energy, zero);
    P = passed_stress(plus(scaled(growth, near.P), P), H, change, at, growth * at.share, growth * rise - half_energy);
  } else {
    P = plus(scaled(growth_of(shape.X, p), near.P), P);
  }
  return plus(scaled(p[0], P), volume_stress(change, p[1]));
}

// In place of squared_condition: times 1 + share_of_shear() stiffening_at() of src/elastic/energy_density.h.
KERNEL real energy_condition(Columns H, real p[energy_constants]) {
  real zero = literal(0.0f);
  real one = literal(1.0f);
  Change change = change_of(H);
  Invariants of = invariants_of(H, change);
  real X = shape_of(H, change, of, near_stress(H, change, of)).X;
  X = select(X > zero, X, zero) + literal(1e-12f);
  real t = exponent_of(X, p);
  real e = exponential(t);
  real second = select(p[4] > zero, p[4], -p[4]) * square_root(X) * (literal(4.0f) / (one + p[5] * X));
  real rise = p[2] * ((e - one) + select(t < literal(4.0f), literal(2.0f) * (t * e), zero)) + second;
  real bulk = p[1];
  real share = literal(2.0f) * p[0] / ((bulk + literal(1.3333334f) * p[0]) * (one + literal(1.6f) * (p[0] / bulk)));
  real condition = squared_condition(H, change);
  real stiffer = condition * (one + share * rise);
  return select(condition < literal(1e6f), select(stiffer < literal(9e5f), stiffer, literal(9e5f)), condition);
}
