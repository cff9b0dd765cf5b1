// SPDX-License-Identifier: MIT
//
// Cell-averaged shape memory as a difference from rest: float twin of force_cell.h. With F = I + H, and for each of the
// seven directions m with t1 x t2 = m, f = t + H t:
//   w0 = m,  dw = (H t1) x f2 + t1 x (H t2),  r = n(F) - F m = dn - H m
// P = dE/dF is exactly 0 at H = 0. A Columns holds a matrix by its columns. Twin: glsl/kernels/delta_cell.glsl.
#pragma once

#include "delta_base.h"
#include "delta_volume.h"

namespace phymul::cpu {

template <class S>
struct Columns {
  Vector3<S> c0, c1, c2;
};

template <class S>
Vector3<S> times(const Columns<S>& H, const Vector3<S>& t) {
  return t.x * H.c0 + t.y * H.c1 + t.z * H.c2;
}

/// A += a (x) b.
template <class S>
void add_outer(Columns<S>& A, const Vector3<S>& a, const Vector3<S>& b) {
  A.c0 += b.x * a;
  A.c1 += b.y * a;
  A.c2 += b.z * a;
}

template <class S>
struct CellPull {
  Vector3<S> f1, f2, n, r;
  S inverse_length;
};

template <class S>
CellPull<S> cell_pull(const Columns<S>& H, const Vector3<S>& m, const Vector3<S>& t1, const Vector3<S>& t2) {
  const Vector3<S> d1 = times(H, t1), d2 = times(H, t2);
  DeltaBase<false, S> base;
  base.e1 = t1 + d1;
  base.e2 = t2 + d2;
  const Vector3<S> dw = cross_product(d1, base.e2) + cross_product(t1, d2);
  const S edges = inner_product(base.e1, base.e1) * inner_product(base.e2, base.e2);
  turn_base(m, cross_product(base.e1, base.e2), dw, edges, S(0.0f), base);
  return {base.e1, base.e2, base.n, base.dn - times(H, m), base.inverse_length};
}

template <class S>
void add_direction(const Columns<S>& H, const Vector3<S>& m, const Vector3<S>& t1, const Vector3<S>& t2,
                   const S& weight, Columns<S>& P) {
  const CellPull<S> d = cell_pull(H, m, t1, t2);
  add_outer(P, -(weight * d.r), m);
  const Vector3<S> G = (weight * d.inverse_length) * (d.r - inner_product(d.n, d.r) * d.n);
  add_outer(P, cross_product(d.f2, G), t1);
  add_outer(P, cross_product(G, d.f1), t2);
}

template <class S>
S direction_energy(const Columns<S>& H, const Vector3<S>& m, const Vector3<S>& t1, const Vector3<S>& t2,
                   const S& weight) {
  const Vector3<S> r = cell_pull(H, m, t1, t2).r;
  return S(0.5f) * weight * inner_product(r, r);
}

/// Calls visit(m, t1, t2, weight) for the four diagonals of a cube and its three axes.
template <class S, class Visit>
void for_each_direction(const Visit& visit) {
  const auto v = [](float x, float y, float z) { return Vector3<S>{S(x), S(y), S(z)}; };
  constexpr float d = 0.57735027f, s = 0.70710678f, a = 0.8164966f, b = 0.4082483f;
  constexpr float diagonal = 0.15f, axis = 0.13333334f;
  visit(v(d, d, d), v(0, -s, s), v(a, -b, -b), S(diagonal));
  visit(v(-d, d, d), v(0, -s, s), v(a, b, b), S(diagonal));
  visit(v(d, -d, d), v(0, -s, -s), v(a, b, -b), S(diagonal));
  visit(v(d, d, -d), v(0, s, s), v(a, -b, b), S(diagonal));
  visit(v(1, 0, 0), v(0, 0, -1), v(0, 1, 0), S(axis));
  visit(v(0, 1, 0), v(0, 0, 1), v(1, 0, 0), S(axis));
  visit(v(0, 0, 1), v(0, -1, 0), v(1, 0, 0), S(axis));
}

/// det(I + H) - 1.
template <class S>
S determinant_change(const Columns<S>& H) {
  const Vector3<S> F1{H.c1.x, S(1.0f) + H.c1.y, H.c1.z}, F2{H.c2.x, H.c2.y, S(1.0f) + H.c2.z};
  return inner_product(H.c0, cross_product(F1, F2)) + (H.c1.y * F2.z - H.c1.z * F2.y) + H.c2.z;
}

/// dE/dF at F = I + H: the force on a corner is -P gradient.
template <bool bounded, class S>
Columns<S> cell_stress(const Columns<S>& H, const S& shape_stiffness, const S& volume_stiffness) {
  Columns<S> P{};
  for_each_direction<S>(
      [&](const auto& m, const auto& t1, const auto& t2, const S& weight) { add_direction(H, m, t1, t2, weight, P); });
  const Vector3<S> F0{S(1.0f) + H.c0.x, H.c0.y, H.c0.z}, F1{H.c1.x, S(1.0f) + H.c1.y, H.c1.z},
      F2{H.c2.x, H.c2.y, S(1.0f) + H.c2.z};
  const S q = volume_stiffness * volume_pressure<bounded>(determinant_change(H));
  return {shape_stiffness * P.c0 + q * cross_product(F1, F2), shape_stiffness * P.c1 + q * cross_product(F2, F0),
          shape_stiffness * P.c2 + q * cross_product(F0, F1)};
}

/// J; for monitors.
template <bool bounded, class S>
S cell_energy(const Columns<S>& H, const S& shape_stiffness, const S& volume_stiffness) {
  S sum = S(0.0f);
  for_each_direction<S>([&](const auto& m, const auto& t1, const auto& t2, const S& weight) {
    sum = sum + direction_energy(H, m, t1, t2, weight);
  });
  return shape_stiffness * sum + volume_stiffness * volume_energy_density<bounded>(determinant_change(H));
}

}  // namespace phymul::cpu
