// SPDX-License-Identifier: MIT
//
// A base as a difference from rest. Notation of topology.h; E1, E2 are edges at rest, d1 = u_b - u_a, d2 = u_c - u_a,
// e = E + d, w0 and n0 belong to rest.
//   dw = w - w0 = d1 x e2 + E1 x d2,   |w| - |w0| = dw . (w + w0) / (|w| + |w0|)
//   dn = n - n0 = (dw - n0 (|w| - |w0|)) / |w|
//   P*_t - x_i = (u_a - u_i) + lambda_b d1 + lambda_c d2 + beta dn
// All of it is exactly 0 where no displacement differs.

struct DeltaBase {
  real3 e1, e2;         // m; e2 is 0 in 2-D
  real3 n;              // unit normal; 0 where the base has collapsed
  real3 dn;             // n - n0
  real inverse_length;  // 1 / |w|; 0 where the base has collapsed
};

// edges: |e1|^2 |e2|^2. A base whose edges meet at an angle of a squared sine below 1e-12, which is what a float can
// tell, has no direction left. The delta form of dn divides by |w| what was rounded at the size of |w0|: below half of
// |w0|, plain n - n0 is better.
KERNEL DeltaBase turned_base(real3 e1, real3 e2, real3 w0, real3 w, real3 dw, real edges) {
  real q0 = inner_product(w0, w0);
  real q = inner_product(w, w);
  real length0 = square_root(q0);
  real length_now = square_root(q);
  real least = literal(1e-12f) * edges;
  real inverse_length = select(q <= least, literal(0.0f), literal(1.0f) / length_now);
  real3 n0 = (literal(1.0f) / length0) * w0;
  real3 n = inverse_length * w;
  real stretch = inner_product(dw, w + w0) * (literal(1.0f) / (length_now + length0));
  real3 dn = select(q < literal(0.25f) * q0, n - n0, inverse_length * (dw - stretch * n0));
  return DeltaBase(e1, e2, n, select(q <= least, -n0, dn), inverse_length);
}

KERNEL DeltaBase delta_base_3d(real3 E1, real3 E2, real3 d1, real3 d2) {
  real3 e1 = E1 + d1;
  real3 e2 = E2 + d2;
  real3 dw = cross_product(d1, e2) + cross_product(E1, d2);
  real edges = inner_product(e1, e1) * inner_product(e2, e2);
  return turned_base(e1, e2, cross_product(E1, E2), cross_product(e1, e2), dw, edges);
}

KERNEL DeltaBase delta_base_2d(real3 E1, real3 d1) {
  real zero = literal(0.0f);
  real3 e1 = E1 + d1;
  return turned_base(e1, real3(zero, zero, zero), real3(-E1.y, E1.x, zero), real3(-e1.y, e1.x, zero),
                     real3(-d1.y, d1.x, zero), zero);
}

// to_a: u_a - u_i
KERNEL real3 base_pull(DeltaBase base, real3 to_a, real3 d1, real3 d2, real lambda_b, real lambda_c, real beta) {
  return to_a + lambda_b * d1 + lambda_c * d2 + beta * base.dn;
}

// beta / |w| (F - n (n . F))
KERNEL real3 height_slope(DeltaBase base, real beta, real3 F) {
  real3 across = F - inner_product(base.n, F) * base.n;
  return (beta * base.inverse_length) * across;
}

// Forces on a, b, c of a base whose owner feels F.
KERNEL void base_reaction_3d(DeltaBase base, real lambda_b, real lambda_c, real beta, real3 F, OUT(real3) on_a,
                             OUT(real3) on_b, OUT(real3) on_c) {
  real3 G = height_slope(base, beta, F);
  on_b = -(lambda_b * F + cross_product(base.e2, G));
  on_c = -(lambda_c * F + cross_product(G, base.e1));
  on_a = -(F + on_b + on_c);
}

KERNEL void base_reaction_2d(DeltaBase base, real lambda_b, real beta, real3 F, OUT(real3) on_a, OUT(real3) on_b) {
  real3 G = height_slope(base, beta, F);
  on_b = -(lambda_b * F + real3(G.y, -G.x, literal(0.0f)));
  on_a = -(F + on_b);
}
