// SPDX-License-Identifier: MIT
//
// The shaders' kernels (glsl/kernels/) as C++: in float, what a shader without contraction computes bit for bit, and in
// numbers that carry a bound of their rounding. The words they are written in: glsl/dialect/kernel_language.glsl.
#pragma once

#include "base/vector3.h"

namespace phymul::cpu {

/// A matrix by its columns.
template <class S>
struct Columns {
  Vector3<S> c0, c1, c2;
};

inline float inverse_root_change(float a, float y) {
  const float root = square_root(a);
  return -y / (root * (1.0f + root));
}

#define KERNEL static
#define OUT(type) type&
#define INOUT(type) type&

/// `bounded`: VolumeLaw::bounded.
template <class S, bool bounded = true>
struct Kernels {
  using real = S;
  using real3 = Vector3<S>;
  using Columns = cpu::Columns<S>;
  static constexpr bool bounded_volume = bounded;
  static real literal(float x) { return S(x); }
  static real inverse_root(const real& x) { return literal(1.0f) / square_root(x); }

#include "kernels/base.glsl"
#include "kernels/columns.glsl"
#include "kernels/energy_shape.glsl"
#include "kernels/integrate.glsl"
#include "kernels/spring.glsl"
#include "kernels/volume.glsl"
};

#undef KERNEL
#undef OUT
#undef INOUT

}  // namespace phymul::cpu
