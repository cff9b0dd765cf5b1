// SPDX-License-Identifier: MIT
//
// Stresses of materials that dissipate (elastic/dissipation.h), slice by slice.
#pragma once

#include "job.h"
#include "kernel_text.h"

namespace phymul::cpu::PHYMUL_ISA {

PHYMUL_INLINE GreenStrain::Symmetric load_symmetric(const float* from) {
  return {load3(from), load3(from + 3 * lanes)};
}
PHYMUL_INLINE void store_symmetric(float* to, const GreenStrain::Symmetric& E) {
  const Pack3 part[2] = {E.normal, E.shear};
  for (int k = 0; k < 2; ++k) {
    store(to + 3 * k * lanes, part[k].x);
    store(to + (3 * k + 1) * lanes, part[k].y);
    store(to + (3 * k + 2) * lanes, part[k].z);
  }
}

/// Adds them to the first Piola stresses P of a slice, whose displacement gradients are H. Not inlined: kernels of
/// bodies that do not dissipate stay as they are.
[[gnu::noinline]] inline void add_dissipation(const simd::Dissipation& body, int slice, const Columns& H, Columns& P) {
  using Of = GreenStrain;
  const std::int64_t first = static_cast<std::int64_t>(slice) * lanes;
  const float* constants = body.constants + first * simd::dissipation_columns;
  const Of::Symmetric E = Of::green_strain(H);
  Of::Symmetric S{};
  std::int64_t at = first * 6 * (int{body.rate} + int{body.branch});
  if (body.rate) {
    const Of::Symmetric change = Of::symmetric_minus(E, body.fresh ? E : load_symmetric(body.strains + at));
    S = Of::symmetric_plus(S, all(body.inverse_dt),
                           Of::isotropic_stress(change, load(constants), load(constants + lanes)));
    store_symmetric(body.next_strains + at, E);
    at += 6 * lanes;
  }
  if (body.branch) {
    const Of::Symmetric before = body.fresh ? E : load_symmetric(body.strains + at);
    const Of::Symmetric q = Of::symmetric_minus(E, before);
    S = Of::symmetric_plus(S, all(1.0f),
                           Of::isotropic_stress(q, load(constants + 2 * lanes), load(constants + 3 * lanes)));
    store_symmetric(body.next_strains + at, Of::symmetric_plus(before, load(constants + 4 * lanes), q));
  }
  P = Of::plus(P, Of::first_piola(H, S));
}

}  // namespace phymul::cpu::PHYMUL_ISA
