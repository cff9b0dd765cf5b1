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

/// a^(-1/3), a > 0; three steps of Newton's method, from a guess that is 4 % off.
PHYMUL_INLINE Pack inverse_cube_root(Pack a) {
  // Thirds of the bits by way of floats: no processor divides integers side by side.
  const Ints third = __builtin_convertvector(__builtin_convertvector((Ints)a, Pack) * 0.33333334f, Ints);
  Pack x = (Pack)(0x54a2fa8d - third);
  for (int k = 0; k < 3; ++k) x += (0.33333334f * x) * (1.0f - (a * x) * (x * x));
  return x;
}

using real = Pack;
using real3 = Pack3;
#define KERNEL PHYMUL_INLINE static
#define KERNEL_CONSTANT static constexpr
#define OUT(type) type&

PHYMUL_INLINE Pack literal(float x) {
  return all(x);
}
PHYMUL_INLINE Pack square_root(Pack x) {
  return x * inverse_root(x);
}
PHYMUL_INLINE Pack inner_product(Pack3 a, Pack3 b) {
  return dot(a, b);
}
PHYMUL_INLINE Pack3 cross_product(Pack3 a, Pack3 b) {
  return cross(a, b);
}

/// `bounded_volume`: VolumeLaw::bounded.
template <bool bounded_volume>
struct VolumeKernels {
#include "kernels/columns.glsl"
#include "kernels/volume.glsl"
};

template <bool bounded_volume>
struct ShapeMemory {
#include "kernels/columns.glsl"
#include "kernels/energy_shape_memory.glsl"
#include "kernels/shape_memory.glsl"
#include "kernels/volume.glsl"
};

template <bool bounded_volume>
struct NeoHookean {
#include "kernels/columns.glsl"
#include "kernels/energy_neo_hookean.glsl"
#include "kernels/volume.glsl"
};

template <bool bounded_volume>
struct Fibres {
#include "kernels/columns.glsl"
#include "kernels/energy_fibres.glsl"
#include "kernels/shape_memory.glsl"
#include "kernels/volume.glsl"
};

/// In the order of StrainEnergy.
template <template <bool bounded_volume> class... Energies>
struct EnergyList {};
using Energies = EnergyList<ShapeMemory, NeoHookean, Fibres>;

#undef KERNEL
#undef KERNEL_CONSTANT
#undef OUT

}  // namespace phymul::cpu::PHYMUL_ISA
