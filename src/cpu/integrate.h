// SPDX-License-Identifier: MIT
//
// Verlet's step as the 2007 thesis has it, x+ = x + d (x - x-) + (f/m) dt^2, written with v = (x - x-) / dt so that
// nothing is lost to cancellation and dt may change between steps:
//   v+ = d v + (f/m) dt,  x+ = x + v+ dt
#pragma once

#include "elastic/force_shape.h"

namespace phymul::cpu {

template <class S>
struct Moved {
  Vec<S> position, velocity;
};

/// An elastic acceleration, cut to `largest`: phymul::SolverOptions::max_displacement_per_step.
template <class S>
Vec<S> cut(const Vec<S>& elastic, S largest) {
  const S size = elastic.norm();
  return size > largest ? Vec<S>(largest / size * elastic) : elastic;
}

template <class S>
Moved<S> integrate(const Vec<S>& position, const Vec<S>& velocity, const Vec<S>& acceleration, S dt, S damping_factor) {
  const Vec<S> v = damping_factor * velocity + dt * acceleration;
  return {position + dt * v, v};
}

}  // namespace phymul::cpu
