// SPDX-License-Identifier: MIT
//
// Volume energy of a tetrahedron (triangle in 2-D): stiffness * u(J), J = volume / rest volume, u(1) = u'(1) = 0,
// u''(1) = 1.
#pragma once

#include <phymul/topology.h>

#include <algorithm>

#include "force_shape.h"

namespace phymul {

/// Of J - 1, beyond which the bounded law is linear.
template <class S>
inline constexpr S volume_bound = S(0.5);

/// u'(J).
template <class S>
S volume_pressure(VolumeLaw law, S J) {
  const S e = J - S(1);
  return law == VolumeLaw::quadratic ? e : std::clamp(e, -volume_bound<S>, volume_bound<S>);
}

template <class S>
S volume_energy_density(VolumeLaw law, S J) {
  const S e = J - S(1), pressure = volume_pressure(law, J);
  return pressure * (e - S(0.5) * pressure);
}

template <class S>
S tetrahedron_ratio(const std::array<Vec<S>, 4>& x, S inverse_rest_volume) {
  return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / S(6) * inverse_rest_volume;
}

template <class S>
S triangle_ratio(const std::array<Vec<S>, 3>& x, S inverse_rest_area) {
  return (x[1] - x[0]).cross(x[2] - x[0]).z() / S(2) * inverse_rest_area;
}

/// -stiffness u'(J) dJ/dx for the four vertices.
template <class S>
std::array<Vec<S>, 4> tetrahedron_volume_forces(VolumeLaw law, const std::array<Vec<S>, 4>& x, S inverse_rest_volume,
                                                S stiffness) {
  const Vec<S> e1 = x[1] - x[0], e2 = x[2] - x[0], e3 = x[3] - x[0];
  const S J = e1.cross(e2).dot(e3) / S(6) * inverse_rest_volume;
  const S q = -stiffness * volume_pressure(law, J) * inverse_rest_volume / S(6);
  const Vec<S> f1 = q * e2.cross(e3), f2 = q * e3.cross(e1), f3 = q * e1.cross(e2);
  return {-(f1 + f2 + f3), f1, f2, f3};
}

template <class S>
std::array<Vec<S>, 3> triangle_area_forces(VolumeLaw law, const std::array<Vec<S>, 3>& x, S inverse_rest_area,
                                           S stiffness) {
  const Vec<S> e1 = x[1] - x[0], e2 = x[2] - x[0];
  const S J = (e1.x() * e2.y() - e1.y() * e2.x()) / S(2) * inverse_rest_area;
  const S q = -stiffness * volume_pressure(law, J) * inverse_rest_area / S(2);
  const Vec<S> f1 = q * Vec<S>(e2.y(), -e2.x(), S(0)), f2 = q * Vec<S>(-e1.y(), e1.x(), S(0));
  return {-(f1 + f2), f1, f2};
}

}  // namespace phymul
