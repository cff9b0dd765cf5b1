// SPDX-License-Identifier: MIT
//
// A spring as a difference from rest: R = X_other - X_self, d = u_other - u_self, r = R + d.
//   |r| - |R| = d . (R + r) / (|r| + |R|),   force on self: k (|r| - |R|) / |r| r
// Two ends at one place have no direction: no force.

// |r| - |R|; 0 for a spring without length, then and now.
KERNEL real spring_stretch(real3 R, real3 d, real3 r, real length_now) {
  real both = length_now + square_root(inner_product(R, R));
  return select(both > literal(0.0f), inner_product(d, R + r) * (literal(1.0f) / both), literal(0.0f));
}

KERNEL real3 spring_force(real3 R, real3 d, real k) {
  real3 r = R + d;
  real length_now = square_root(inner_product(r, r));
  real tension = k * spring_stretch(R, d, r, length_now) * (literal(1.0f) / length_now);
  real zero = literal(0.0f);
  return select(length_now > literal(0.0f), tension * r, real3(zero, zero, zero));
}
