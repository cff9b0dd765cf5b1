// SPDX-License-Identifier: MIT
//
// A base as a difference from rest: float twin of force_shape.h. Notation of topology.h; E1, E2 are edges at rest,
// d1 = u_b - u_a, d2 = u_c - u_a, e = E + d, w0 and n0 belong to rest.
//   dw = w - w0 = d1 x e2 + E1 x d2,   |w| - |w0| = dw . (w + w0) / (|w| + |w0|)
//   dn = n - n0 = (dw - n0 (|w| - |w0|)) / |w|
//   P*_t - x_i = (u_a - u_i) + lambda_b d1 + lambda_c d2 + beta (g n - n0),   g n - n0 = g dn + (g - 1) n0
// All of it is exactly 0 where no displacement differs. Twin: glsl/kernels/delta_base.glsl, where `scaled` (the body
// has an area exponent p) is the macro AREA_EXPONENT.
#pragma once

#include <array>

#include "delta_height.h"

namespace phymul::cpu {

template <bool scaled, class S>
struct DeltaBase {
  Vector3<S> e1, e2;        ///< m; e2 is 0 in 2-D
  Vector3<S> n;             ///< unit normal; 0 where the base has collapsed
  Vector3<S> dn;            ///< n - n0
  Vector3<S> change;        ///< g n - n0; dn where the height does not scale
  S inverse_length;         ///< 1 / |w|; 0 where the base has collapsed
  DeltaHeight<S> height{};  ///< scaled only
  S inverse_rest_length{};  ///< 1 / |w0|; scaled only
};

/// Square of the sine of e1 and e2 below which a base has no direction left; what a float can tell.
inline constexpr float collapsed_sine_squared = 1e-12f;

/// The delta form of dn divides by |w| what was rounded at the size of |w0|. Below half of |w0| plain n - n0 is better.
template <class S>
Vector3<S> normal_change(const Vector3<S>& n0, const Vector3<S>& n, const Vector3<S>& dw, const S& stretch,
                         const S& inverse_length, const S& q0, const S& q) {
  return select(q < S(0.25f) * q0, n - n0, inverse_length * (dw - stretch * n0));
}

/// Fills in what follows from w0, w and dw; `edges` is |e1|^2 |e2|^2.
template <bool scaled, class S>
void turn_base(const Vector3<S>& w0, const Vector3<S>& w, const Vector3<S>& dw, const S& edges, const S& p,
               DeltaBase<scaled, S>& base) {
  const S q0 = inner_product(w0, w0), q = inner_product(w, w);
  const S length0 = square_root(q0), length = square_root(q);
  const S inverse0 = S(1.0f) / length0;
  const auto collapsed = q <= S(collapsed_sine_squared) * edges;
  base.inverse_length = select(collapsed, S(0.0f), S(1.0f) / length);
  const Vector3<S> n0 = inverse0 * w0;
  base.n = base.inverse_length * w;
  const S growth = inner_product(dw, w + w0);  // |w|^2 - |w0|^2
  const S stretch = growth * (S(1.0f) / (length + length0));
  base.dn = normal_change(n0, base.n, dw, stretch, base.inverse_length, q0, q);
  base.dn = select(collapsed, -n0, base.dn);
  base.change = base.dn;
  if constexpr (scaled) {
    base.inverse_rest_length = inverse0;
    base.height = delta_height(S(0.5f) * growth * (inverse0 * inverse0), length * inverse0, p);
    base.change = base.height.value * base.dn + base.height.excess * n0;
  }
}

template <bool scaled, class S>
DeltaBase<scaled, S> delta_base_3d(const Vector3<S>& E1, const Vector3<S>& E2, const Vector3<S>& d1,
                                   const Vector3<S>& d2, const S& p) {
  DeltaBase<scaled, S> base;
  base.e1 = E1 + d1;
  base.e2 = E2 + d2;
  const Vector3<S> dw = cross_product(d1, base.e2) + cross_product(E1, d2);
  const S edges = inner_product(base.e1, base.e1) * inner_product(base.e2, base.e2);
  turn_base(cross_product(E1, E2), cross_product(base.e1, base.e2), dw, edges, p, base);
  return base;
}

template <bool scaled, class S>
DeltaBase<scaled, S> delta_base_2d(const Vector3<S>& E1, const Vector3<S>& d1, const S& p) {
  DeltaBase<scaled, S> base;
  base.e1 = E1 + d1;
  base.e2 = Vector3<S>{};
  const S zero = S(0.0f);
  turn_base<scaled, S>({-E1.y, E1.x, zero}, {-base.e1.y, base.e1.x, zero}, {-d1.y, d1.x, zero}, zero, p, base);
  return base;
}

/// P*_t - x_i; `to_a` is u_a - u_i.
template <bool scaled, class S>
Vector3<S> base_pull(const DeltaBase<scaled, S>& base, const Vector3<S>& to_a, const Vector3<S>& d1,
                     const Vector3<S>& d2, const S& lambda_b, const S& lambda_c, const S& beta) {
  return to_a + lambda_b * d1 + lambda_c * d2 + beta * base.change;
}

/// G = beta [ g/|w| (F - n (n.F)) + g'/|w0| n (n.F) ].
template <bool scaled, class S>
Vector3<S> height_slope(const DeltaBase<scaled, S>& base, const S& beta, const Vector3<S>& F) {
  const S along = inner_product(base.n, F);
  const Vector3<S> across = F - along * base.n;
  if constexpr (scaled) {
    const Vector3<S> G = (beta * base.height.value * base.inverse_length) * across;
    return G + (beta * base.height.slope * base.inverse_rest_length * along) * base.n;
  } else {
    return (beta * base.inverse_length) * across;
  }
}

/// Forces on a, b, c of a base whose owner feels F.
template <bool scaled, class S>
std::array<Vector3<S>, 3> base_reaction_3d(const DeltaBase<scaled, S>& base, const S& lambda_b, const S& lambda_c,
                                           const S& beta, const Vector3<S>& F) {
  const Vector3<S> G = height_slope(base, beta, F);
  const Vector3<S> on_b = -(lambda_b * F + cross_product(base.e2, G));
  const Vector3<S> on_c = -(lambda_c * F + cross_product(G, base.e1));
  return {-(F + on_b + on_c), on_b, on_c};
}

template <bool scaled, class S>
std::array<Vector3<S>, 3> base_reaction_2d(const DeltaBase<scaled, S>& base, const S& lambda_b, const S& beta,
                                           const Vector3<S>& F) {
  const Vector3<S> G = height_slope(base, beta, F);
  const Vector3<S> on_b = -(lambda_b * F + Vector3<S>{G.y, -G.x, S(0.0f)});
  return {-(F + on_b), on_b, Vector3<S>{}};
}

/// Energy of a pull of stiffness k, J; for monitors.
template <class S>
S pull_energy(const S& k, const Vector3<S>& pull) {
  return S(0.5f) * k * inner_product(pull, pull);
}

}  // namespace phymul::cpu
