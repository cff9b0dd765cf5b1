// SPDX-License-Identifier: MIT
//
// Volume energy of a tetrahedron (triangle in 2-D) as a difference from rest: float twin of force_volume.h. E are edges
// at rest, d differences of displacements to the first vertex, e = E + d:
//   e1 x e2 . e3 - E1 x E2 . E3 = (d1 x e2 + E1 x d2) . e3 + (E1 x E2) . d3
// so that J - 1 is exactly 0 at rest. Twin: glsl/kernels/delta_volume.glsl, where `bounded` is the macro
// BOUNDED_VOLUME.
#pragma once

#include <array>

#include "base/vector3.h"

namespace phymul::cpu {

/// u'(J) from J - 1.
template <bool bounded, class S>
S volume_pressure(const S& change) {
  if constexpr (!bounded) return change;
  const S x = change * S(2.5f);  // over s = 0.4, where u' saturates
  return change * (S(1.0f) / square_root(S(1.0f) + x * x));
}

/// u(J) from J - 1; for monitors.
template <bool bounded, class S>
S volume_energy_density(const S& change) {
  if constexpr (!bounded) return S(0.5f) * change * change;
  const S x = change * S(2.5f);
  return change * change * (S(1.0f) / (S(1.0f) + square_root(S(1.0f) + x * x)));
}

/// J - 1; `inverse` is 1 / (6 V).
template <class S>
S tetrahedron_change(const std::array<Vector3<S>, 3>& E, const std::array<Vector3<S>, 3>& d, const S& inverse) {
  const Vector3<S> e2 = E[1] + d[1], e3 = E[2] + d[2];
  const Vector3<S> dw = cross_product(d[0], e2) + cross_product(E[0], d[1]);
  return (inner_product(dw, e3) + inner_product(cross_product(E[0], E[1]), d[2])) * inverse;
}

/// Forces on the four vertices.
template <bool bounded, class S>
std::array<Vector3<S>, 4> tetrahedron_volume_forces(const std::array<Vector3<S>, 3>& E,
                                                    const std::array<Vector3<S>, 3>& d, const S& inverse,
                                                    const S& stiffness) {
  const Vector3<S> e1 = E[0] + d[0], e2 = E[1] + d[1], e3 = E[2] + d[2];
  const S q = -(stiffness * volume_pressure<bounded>(tetrahedron_change(E, d, inverse)) * inverse);
  const Vector3<S> f1 = q * cross_product(e2, e3), f2 = q * cross_product(e3, e1), f3 = q * cross_product(e1, e2);
  return {-(f1 + f2 + f3), f1, f2, f3};
}

/// The same in the plane; `inverse` is 1 / (2 A).
template <class S>
S triangle_change(const std::array<Vector3<S>, 2>& E, const std::array<Vector3<S>, 2>& d, const S& inverse) {
  const Vector3<S> e2 = E[1] + d[1];
  return ((d[0].x * e2.y - d[0].y * e2.x) + (E[0].x * d[1].y - E[0].y * d[1].x)) * inverse;
}

template <bool bounded, class S>
std::array<Vector3<S>, 3> triangle_area_forces(const std::array<Vector3<S>, 2>& E, const std::array<Vector3<S>, 2>& d,
                                               const S& inverse, const S& stiffness) {
  const Vector3<S> e1 = E[0] + d[0], e2 = E[1] + d[1];
  const S q = -(stiffness * volume_pressure<bounded>(triangle_change(E, d, inverse)) * inverse);
  const Vector3<S> f1 = q * Vector3<S>{e2.y, -e2.x, S(0.0f)}, f2 = q * Vector3<S>{-e1.y, e1.x, S(0.0f)};
  return {-(f1 + f2), f1, f2};
}

}  // namespace phymul::cpu
