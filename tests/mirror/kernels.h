// SPDX-License-Identifier: MIT
//
// The shaders' kernels (glsl/kernels/) as C++: in float, what a shader without contraction computes bit for bit, and in
// numbers that carry a bound of their rounding. The words they are written in: glsl/dialect/kernel_language.glsl.
#pragma once

#include <phymul/topology.h>

#include <bit>
#include <cstdint>

#include "base/vector3.h"

namespace phymul::cpu {

/// A matrix by its columns.
template <class S>
struct Columns {
  Vector3<S> c0, c1, c2;
};

inline float quotient(float a, float b) {
  return a * (1.0f / b);
}

inline float inverse_root_change(float a, float y) {
  const float root = square_root(a);
  return -y * (1.0f / (root * (1.0f + root)));
}

inline float inverse_cube_root(float a) {
  float x = std::bit_cast<float>(0x54a2fa8d - std::bit_cast<std::int32_t>(a) / 3);
  for (int k = 0; k < 3; ++k) x = x + (0.33333334f * x) * (1.0f - (a * x) * (x * x));
  return x;
}

#define KERNEL static
#define KERNEL_CONSTANT static constexpr
#define OUT(type) type&
#define INOUT(type) type&
#define PHYMUL_KERNEL_WORDS                 \
  using real = S;                           \
  using real3 = Vector3<S>;                 \
  using Columns = cpu::Columns<S>;          \
  static real literal(float x) {            \
    return S(x);                            \
  }                                         \
  static real inverse_root(const real& x) { \
    return literal(1.0f) / square_root(x);  \
  }

/// All but the energies of domains. `bounded_volume`: VolumeLaw::bounded.
template <class S, bool bounded_volume = true>
struct Kernels {
  PHYMUL_KERNEL_WORDS
#include "kernels/base.glsl"
#include "kernels/columns.glsl"
#include "kernels/integrate.glsl"
#include "kernels/joint.glsl"
#include "kernels/spring.glsl"
#include "kernels/volume.glsl"
#include "kernels/wall.glsl"
};

template <class S>
struct GreenStrain {
  PHYMUL_KERNEL_WORDS
#include "kernels/columns.glsl"
#include "kernels/green_strain.glsl"
};

template <class S, bool bounded_volume = true>
struct NeoHookean {
  PHYMUL_KERNEL_WORDS
#include "kernels/columns.glsl"
#include "kernels/energy_neo_hookean.glsl"
#include "kernels/neo_hookean.glsl"
#include "kernels/volume.glsl"
};

template <class S, bool bounded_volume = true>
struct Stiffening {
  PHYMUL_KERNEL_WORDS
  // The energy needs structs of the file before it.
  // clang-format off
#include "kernels/columns.glsl"
#include "kernels/volume.glsl"
#include "kernels/neo_hookean.glsl"
#include "kernels/energy_stiffening.glsl"
  // clang-format on
};

template <class S, bool bounded_volume = true>
struct Fibres {
  PHYMUL_KERNEL_WORDS
#include "kernels/columns.glsl"
#include "kernels/energy_fibres.glsl"
#include "kernels/neo_hookean.glsl"
#include "kernels/volume.glsl"
};

/// Calls with an object of the energy's kernels.
template <class S, class Call>
void with_energy(const TopologyOptions& options, const Call& call) {
  const bool bounded = options.volume_law == VolumeLaw::bounded;
  switch (options.strain_energy) {
    case StrainEnergy::neo_hookean:
      return bounded ? call(NeoHookean<S, true>{}) : call(NeoHookean<S, false>{});
    case StrainEnergy::fibres:
      return bounded ? call(Fibres<S, true>{}) : call(Fibres<S, false>{});
    case StrainEnergy::stiffening:
      return bounded ? call(Stiffening<S, true>{}) : call(Stiffening<S, false>{});
  }
}

#undef KERNEL
#undef KERNEL_CONSTANT
#undef OUT
#undef INOUT
#undef PHYMUL_KERNEL_WORDS

}  // namespace phymul::cpu
