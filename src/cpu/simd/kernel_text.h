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
  const Ints third = PHYMUL_CONVERTED(PHYMUL_CONVERTED((Ints)a.v, Floats) * 0.33333334f, Ints);
  Pack x = (Floats)(0x54a2fa8d - third);
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
  return root(x);
}
PHYMUL_INLINE Pack quotient(Pack a, Pack b) {
  return a / b;
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

struct Wall {
#include "kernels/wall.glsl"
};

struct GreenStrain {
#include "kernels/columns.glsl"
#include "kernels/green_strain.glsl"
};

template <bool bounded_volume>
struct NeoHookean {
#include "kernels/columns.glsl"
#include "kernels/energy_neo_hookean.glsl"
#include "kernels/neo_hookean.glsl"
#include "kernels/volume.glsl"
};

template <bool bounded_volume>
struct Stiffening {
  // The energy needs structs of the file before it.
  // clang-format off
#include "kernels/columns.glsl"
#include "kernels/volume.glsl"
#include "kernels/neo_hookean.glsl"
#include "kernels/energy_stiffening.glsl"
  // clang-format on
};

template <bool bounded_volume>
struct Fibres {
#include "kernels/columns.glsl"
#include "kernels/energy_fibres.glsl"
#include "kernels/neo_hookean.glsl"
#include "kernels/volume.glsl"
};

/// The change of an energy's stress at I + H with a small change of H: a difference over a step that depends on the
/// change alone, so that large and small ones have the same relative error, about 1e-5. Its constants are the energy's,
/// then the nine numbers of H by columns.
template <class Energy>
struct TangentOf {
  static constexpr int energy_constants = Energy::energy_constants + 9;

  PHYMUL_INLINE static Columns scaled(Pack s, const Columns& A) { return Energy::scaled(s, A); }

  PHYMUL_INLINE static Columns energy_stress(const Columns& change, const Pack* p) {
    const Pack* at = p + Energy::energy_constants;
    const Columns H{{at[0], at[1], at[2]}, {at[3], at[4], at[5]}, {at[6], at[7], at[8]}};
    const Pack square = Energy::squared_norm(change) + all(1e-30f);
    const Pack inverse = inverse_root(square), step = all(3e-3f) * inverse;
    const Columns way = Energy::scaled(step, change);
    Pack constants[Energy::energy_constants];
    for (int k = 0; k < Energy::energy_constants; ++k) constants[k] = p[k];
    const Columns after = Energy::energy_stress(Energy::plus(H, way), constants);
    const Columns before = Energy::energy_stress(Energy::minus(H, way), constants);
    return Energy::scaled(all(0.5f / 3e-3f) * square * inverse, Energy::minus(after, before));
  }
};

/// The same at H = 0, where it is Hooke's law with fibres (stress_near_rest() in elastic/energy_density.h). Constants:
/// mu, lambda, and of fibres k and a; k is 0 where there are none.
struct StressNearRest {
#include "kernels/columns.glsl"
  static constexpr int energy_constants = 6;

  PHYMUL_INLINE static Columns energy_stress(const Columns& H, const Pack* p) {
    const Pack3 a{p[3], p[4], p[5]};
    const Pack volume = p[1] * ((H.c0.x + H.c1.y) + H.c2.z), along = p[2] * dot(a, times(H, a));
    const Columns twice_symmetric{{H.c0.x + H.c0.x, H.c0.y + H.c1.x, H.c0.z + H.c2.x},
                                  {H.c1.x + H.c0.y, H.c1.y + H.c1.y, H.c1.z + H.c2.y},
                                  {H.c2.x + H.c0.z, H.c2.y + H.c1.z, H.c2.z + H.c2.z}};
    Columns P = plus_outer(scaled(p[0], twice_symmetric), along * a, a);
    P.c0.x += volume;
    P.c1.y += volume;
    P.c2.z += volume;
    return P;
  }
};

/// In the order of StrainEnergy.
template <template <bool bounded_volume> class... Energies>
struct EnergyList {};
using Energies = EnergyList<NeoHookean, Fibres, Stiffening>;

#undef KERNEL
#undef KERNEL_CONSTANT
#undef OUT

}  // namespace phymul::cpu::PHYMUL_ISA
