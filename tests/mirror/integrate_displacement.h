// SPDX-License-Identifier: MIT
//
// Verlet's step (integrate.h) for a displacement u and a velocity v:
//   a = f / m + g,  v+ = d v + dt a,  u+ = u + dt v+
// Imposed coordinates have u+ = target and v+ = (target - u) / dt. Twin: glsl/kernels/integrate_displacement.glsl.
#pragma once

#include "base/vector3.h"

namespace phymul::cpu {

template <class S>
Vector3<S> acceleration(const Vector3<S>& force, const S& inverse_mass, const Vector3<S>& gravity) {
  return inverse_mass * force + gravity;
}

/// An elastic force, cut to `largest`: SolverOptions::max_displacement_per_step.
template <class S>
Vector3<S> cut_force(const Vector3<S>& force, const S& largest) {
  const S q = inner_product(force, force);
  return select(q > largest * largest, (largest * (S(1.0f) / square_root(q))) * force, force);
}

template <class S>
struct Displaced {
  Vector3<S> u, v;
};

template <class S>
Displaced<S> integrate_displacement(const Vector3<S>& u, const Vector3<S>& v, const Vector3<S>& a, const S& dt,
                                    const S& damping_factor) {
  const Vector3<S> v_next = damping_factor * v + dt * a;
  return {u + dt * v_next, v_next};
}

/// Overwrites the coordinates whose mask is set; `before` is u before the step.
template <class Mask, class S>
void impose(Displaced<S>& moved, const Mask& x, const Mask& y, const Mask& z, const Vector3<S>& target,
            const Vector3<S>& before, const S& inverse_dt) {
  const Vector3<S> v = inverse_dt * (target - before);
  moved.u = {select(x, target.x, moved.u.x), select(y, target.y, moved.u.y), select(z, target.z, moved.u.z)};
  moved.v = {select(x, v.x, moved.v.x), select(y, v.y, moved.v.y), select(z, v.z, moved.v.z)};
}

}  // namespace phymul::cpu
