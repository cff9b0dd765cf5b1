// SPDX-License-Identifier: MIT
//
// The shaders' kernels (glsl/kernels/) for packs. The words they are written in: glsl/dialect/kernel_language.glsl.
#pragma once

#include "pack.h"

namespace phymul::cpu::PHYMUL_ISA {

/// A matrix by its columns.
struct Columns {
  Pack3 c0, c1, c2;
};

#define KERNEL PHYMUL_INLINE static
#define OUT(type) type&

/// `bounded`: VolumeLaw::bounded.
template <bool bounded>
struct Kernels {
  using real = Pack;
  using real3 = Pack3;
  using Columns = PHYMUL_ISA::Columns;
  static constexpr bool bounded_volume = bounded;
  KERNEL Pack literal(float x) { return all(x); }
  KERNEL Pack square_root(Pack x) { return x * inverse_root(x); }
  KERNEL Pack inner_product(Pack3 a, Pack3 b) { return dot(a, b); }
  KERNEL Pack3 cross_product(Pack3 a, Pack3 b) { return cross(a, b); }

#include "kernels/columns.glsl"
#include "kernels/energy_shape.glsl"
#include "kernels/volume.glsl"
};

#undef KERNEL
#undef OUT

}  // namespace phymul::cpu::PHYMUL_ISA
