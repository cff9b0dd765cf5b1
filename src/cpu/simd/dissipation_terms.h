// SPDX-License-Identifier: MIT
//
// Stresses of materials that dissipate (elastic/dissipation.h), slice by slice.
#pragma once

#include "averaged_runs.h"

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

/// First Piola stresses of a slice, from its sums of displacements times areas.
PHYMUL_INLINE Columns dissipated_stress(const simd::Averaged& body, int slice) {
  using Of = GreenStrain;
  const simd::Dissipation& how = *body.dissipation;
  const std::int64_t first = static_cast<std::int64_t>(slice) * lanes;
  const float* sums = body.sums + 9 * first;
  const Columns H = Of::scaled(load(body.constants + how.elastic_columns * first),
                               {load3(sums), load3(sums + 3 * lanes), load3(sums + 6 * lanes)});
  const float* constants = how.constants + first * simd::dissipation_columns;
  const Of::Symmetric E = Of::green_strain(H);
  Of::Symmetric S{};
  std::int64_t at = first * 6 * (int{how.rate} + int{how.branch});
  if (how.rate) {
    const Of::Symmetric change = Of::symmetric_minus(E, how.fresh ? E : load_symmetric(how.strains + at));
    S = Of::symmetric_plus(S, all(how.inverse_dt),
                           Of::isotropic_stress(change, load(constants), load(constants + lanes)));
    store_symmetric(how.next_strains + at, E);
    at += 6 * lanes;
  }
  if (how.branch) {
    const Of::Symmetric before = how.fresh ? E : load_symmetric(how.strains + at);
    const Of::Symmetric q = Of::symmetric_minus(E, before);
    S = Of::symmetric_plus(S, all(1.0f),
                           Of::isotropic_stress(q, load(constants + 2 * lanes), load(constants + 3 * lanes)));
    store_symmetric(how.next_strains + at, Of::symmetric_plus(before, load(constants + 4 * lanes), q));
  }
  Columns P = Of::first_piola(H, S);
  if (body.plane) P.c0.z = P.c1.z = P.c2.z = Pack{};  // as in averaged_stress
  return P;
}

inline void add_dissipation(const simd::Averaged& body, int slice, int end) {
  alignas(64) float rows[3][4 * lanes];
  for (; slice < end; ++slice) {
    const Columns P = dissipated_stress(body, slice);
    const Pack3 column[3] = {P.c0, P.c1, P.c2};
    for (int c = 0; c < 3; ++c) store_row(reinterpret_cast<char*>(rows[c]), column[c]);
    char* to = body.stress + 64 * static_cast<std::int64_t>(slice) * lanes;
    for (int k = 0; k < lanes; ++k) {
      for (int c = 0; c < 3; ++c) {
        char* const at = to + 64 * k + 16 * c;
        store_quad(at, load_quad(at) + load_quad(reinterpret_cast<const char*>(rows[c]) + 16 * k));
      }
    }
  }
}

inline void run_dissipation(const simd::Averaged& body, int slice, int end) {
  const simd::Runs& runs = body.runs;
  for (; slice < end; ++slice) {
    const Columns P = dissipated_stress(body, slice);
    float* at = runs.components + simd::run_stress * runs.stride + static_cast<std::int64_t>(slice) * lanes;
    const Pack3 column[3] = {P.c0, P.c1, P.c2};
    for (int c = 0; c < 3; ++c, at += 3 * runs.stride) {
      store_components(runs, at, load_components(runs, at) + column[c], lanes);
    }
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
