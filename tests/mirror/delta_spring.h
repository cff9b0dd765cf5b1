// SPDX-License-Identifier: MIT
//
// A spring as a difference from rest: R = X_other - X_self, d = u_other - u_self, r = R + d.
//   |r| - |R| = d . (R + r) / (|r| + |R|),   force on self: k (|r| - |R|) / |r| r
// Two ends at one place have no direction: no force. Twin: glsl/kernels/delta_spring.glsl.
#pragma once

#include "base/vector3.h"

namespace phymul::cpu {

/// |r| - |R|; 0 for a spring without length, then and now.
template <class S>
S spring_stretch(const Vector3<S>& R, const Vector3<S>& d, const Vector3<S>& r, const S& length) {
  const S both = length + square_root(inner_product(R, R));
  return select(both > S(0.0f), inner_product(d, R + r) * (S(1.0f) / both), S(0.0f));
}

template <class S>
Vector3<S> spring_force(const Vector3<S>& R, const Vector3<S>& d, const S& k) {
  const Vector3<S> r = R + d;
  const S length = square_root(inner_product(r, r));
  const S tension = k * spring_stretch(R, d, r, length) * (S(1.0f) / length);
  return select(length > S(0.0f), tension * r, Vector3<S>{});
}

/// J; for monitors.
template <class S>
S spring_energy(const Vector3<S>& R, const Vector3<S>& d, const S& k) {
  const Vector3<S> r = R + d;
  const S stretch = spring_stretch(R, d, r, square_root(inner_product(r, r)));
  return S(0.5f) * k * stretch * stretch;
}

}  // namespace phymul::cpu
