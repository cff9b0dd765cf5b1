// SPDX-License-Identifier: MIT
//
// The shape-memory model at F = I + H, of energy density c W(F), Pa, with
//   W = 1/2 sum of weight |n_m(F) - F m|^2 over seven unit vectors m,  n_m(F) = cof(F) m / |cof(F) m|
// (src/elastic/energy_density.h): its derivative by F. Exactly 0 at H = 0. Needs columns.glsl.

// Of a direction m, which need not be a unit vector; norm = 1 / |m|^2.
struct Direction {
  real3 r;  // |m| n_m(F) - F m
  real3 G;  // rho (r - n (n . r)), rho = |m| / |cof(F) m|
};

// dw = cof(F) m - m, Hm = H m. Where |cof(F) m|^2 / |m|^2 is below `least`, there is no normal.
KERNEL Direction direction(real3 m, real3 dw, real3 Hm, real least, real norm) {
  real3 w = m + dw;
  real q = norm * inner_product(w, w);
  real y = norm * inner_product(dw, w + m);
  real c = select(q > least, inverse_root_change(q, y), literal(-1.0f));
  real3 r = dw + c * w - Hm;
  real rho = c + literal(1.0f);
  real along = (norm * rho) * (rho * inner_product(w, r));
  return Direction(r, rho * (r - along * w));
}

// The diagonals (1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1) of a cube, and its axes.
struct Directions {
  Direction a, b, c, d, x, y, z;
};

KERNEL Directions directions(Columns H, Columns C) {
  real one = literal(1.0f);
  real zero = literal(0.0f);
  real third = literal(0.33333334f);
  // Of two unit vectors across m, |F t1| |F t2| is at most half the squared norm of F: this bounds the square of |w|
  // below which it is collapsed.
  real squares = squared_norm(plus_identity(H));
  real least = literal(0.25e-12f) * squares * squares;
  real3 Cp = C.c0 + C.c1;
  real3 Cm = C.c1 - C.c0;
  real3 Hp = H.c0 + H.c1;
  real3 Hm = H.c1 - H.c0;
  return Directions(direction(real3(one, one, one), Cp + C.c2, Hp + H.c2, least, third),
                    direction(real3(-one, one, one), Cm + C.c2, Hm + H.c2, least, third),
                    direction(real3(one, -one, one), C.c2 - Cm, H.c2 - Hm, least, third),
                    direction(real3(one, one, -one), Cp - C.c2, Hp - H.c2, least, third),
                    direction(real3(one, zero, zero), C.c0, H.c0, least, one),
                    direction(real3(zero, one, zero), C.c1, H.c1, least, one),
                    direction(real3(zero, zero, one), C.c2, H.c2, least, one));
}

// Sum of weight (v (x) m) over the directions; weights 0.15 / 3 and 2 / 15.
KERNEL Columns weighted_sum(real3 a, real3 b, real3 c, real3 d, real3 x, real3 y, real3 z) {
  real diagonal = literal(0.05f);
  real axis = literal(0.13333334f);
  real3 ad = a + d;
  real3 bc = c - b;
  return Columns(diagonal * (ad + bc) + axis * x, diagonal * (ad - bc) + axis * y,
                 diagonal * ((a - d) + (b + c)) + axis * z);
}

KERNEL Columns shape_stress(Columns H, Change change, real c) {
  Columns F = plus_identity(H);
  Directions d = directions(H, change.cof);
  Columns R = weighted_sum(d.a.r, d.b.r, d.c.r, d.d.r, d.x.r, d.y.r, d.z.r);
  Columns A = weighted_sum(d.a.G, d.b.G, d.c.G, d.d.G, d.x.G, d.y.G, d.z.G);
  // The derivative of cof(F) : A.
  Columns P = Columns(cross_product(A.c1, F.c2) + cross_product(F.c1, A.c2),
                      cross_product(A.c2, F.c0) + cross_product(F.c2, A.c0),
                      cross_product(A.c0, F.c1) + cross_product(F.c0, A.c1));
  return scaled(c, minus(P, R));
}
