// SPDX-License-Identifier: MIT
//
// Spring: force on its first end, k (|r| - l) r / |r| with r = x_second - x_first; the second feels the opposite.
// Two ends at one place have no direction: no force.
#pragma once

#include "force_shape.h"

namespace phymul {

template <class S>
Vec<S> spring_force(const Vec<S>& first, const Vec<S>& second, S rest_length, S stiffness) {
  const Vec<S> r = second - first;
  const S length = r.norm();
  if (length == S(0)) return Vec<S>::Zero();
  return (stiffness * (length - rest_length) / length) * r;
}

template <class S>
S spring_energy(const Vec<S>& first, const Vec<S>& second, S rest_length, S stiffness) {
  const S stretch = (second - first).norm() - rest_length;
  return S(0.5) * stiffness * stretch * stretch;
}

}  // namespace phymul
