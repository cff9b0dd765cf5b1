// SPDX-License-Identifier: MIT
//
// Law::particle_averaged on lattices (simd::Runs): a lane is a slot, constants are the same for all of them, and what
// they gather stands side by side.
#pragma once

#include "averaged_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

/// A vector's components at a slot.
PHYMUL_INLINE Pack3 load_components(const simd::Runs& runs, const float* from) {
  return {load(from), load(from + runs.stride), load(from + 2 * runs.stride)};
}
/// Of the first `count` lanes.
PHYMUL_INLINE void store_component(float* to, Pack p, std::int64_t count) {
  if (count >= lanes) return store(to, p);
  for (int k = 0; k < count; ++k) to[k] = p[k];
}
PHYMUL_INLINE void store_components(const simd::Runs& runs, float* to, Pack3 v, std::int64_t count) {
  store_component(to, v.x, count);
  store_component(to + runs.stride, v.y, count);
  store_component(to + 2 * runs.stride, v.z, count);
}

/// Displacements of slices [slice, end).
inline void spread_displacements(const simd::Averaged& body, int slice, int end) {
  for (; slice < end; ++slice) {
    const std::int64_t at = static_cast<std::int64_t>(slice) * lanes;
    store_components(body.runs, body.runs.components + simd::run_u * body.runs.stride + at,
                     gather_row(body.u + 16 * at), lanes);
  }
}

/// Calls sum(stencil, components of a slot, count) for `lanes` slots at a time, of which the first `count` belong to
/// slices [slice, end), and finish(slice) where a slice is complete. Lanes beyond a run come to nothing: what they
/// store is overwritten, because runs come in their order. The last lanes of a long run overlap those before.
template <class Sum, class Finish>
PHYMUL_INLINE void for_each_run(const simd::Averaged& body, int slice, int end, const Sum& sum, const Finish& finish) {
  const simd::Runs& runs = body.runs;
  const std::int64_t last = static_cast<std::int64_t>(end) * lanes;
  std::int64_t first = static_cast<std::int64_t>(slice) * lanes;
  for (const simd::Run* run = runs.runs + runs.first_run[slice]; first < last; ++run) {
    const std::int64_t stop = run[1].first < last ? run[1].first : last;
    for (std::int64_t at = first; at < stop; at += lanes) {
      if (at + lanes > stop && stop - lanes >= first) at = stop - lanes;
      sum(runs.stencils[run->stencil], runs.components + at, last - at);
    }
    for (; (slice + 1) * std::int64_t{lanes} <= stop; ++slice) finish(slice);
    first = stop;
  }
}

/// The sums of averaged_stresses().
struct RunSums {
  Pack3 x, y, z, spring;
};
template <int axes>
PHYMUL_INLINE void add_displacements(const simd::Runs& runs, const simd::Stencil& stencil, const float* at,
                                     RunSums& to) {
  const float* own = at + simd::run_u * runs.stride;
  for (std::int32_t k = stencil.first[axes]; k < stencil.first[axes + 1]; ++k) {
    const simd::RunLink& link = runs.links[k];
    const Pack3 u = load_components(runs, own + link.shift) - load_components(runs, own);
    if constexpr ((axes & 1) != 0) to.x += all(link.there[0]) * u;
    if constexpr ((axes & 2) != 0) to.y += all(link.there[1]) * u;
    if constexpr ((axes & 4) != 0) to.z += all(link.there[2]) * u;
    to.spring += all(link.stiffness) * u;
  }
}
/// Adds a column of stresses times an axis of areas.
PHYMUL_INLINE void add_column(const simd::Runs& runs, const simd::RunLink& link, const float* at, int axis, Pack3& to) {
  to += all(link.back[axis]) * load_components(runs, at + (simd::run_stress + 3 * axis) * runs.stride + link.shift);
}
/// A sum for each axis: products need not wait for each other.
template <int axes>
PHYMUL_INLINE void add_stresses(const simd::Runs& runs, const simd::Stencil& stencil, const float* at, Columns& to) {
  for (std::int32_t k = stencil.first[axes]; k < stencil.first[axes + 1]; ++k) {
    if constexpr ((axes & 1) != 0) add_column(runs, runs.links[k], at, 0, to.c0);
    if constexpr ((axes & 2) != 0) add_column(runs, runs.links[k], at, 1, to.c1);
    if constexpr ((axes & 4) != 0) add_column(runs, runs.links[k], at, 2, to.c2);
  }
}

template <class Energy>
void run_stresses(const simd::Averaged& body, int slice, int end) {
  const simd::Runs& runs = body.runs;
  for_each_run(
      body, slice, end,
      [&](const simd::Stencil& stencil, float* at, std::int64_t count) PHYMUL_INLINED {
        RunSums sums{};
        add_displacements<0>(runs, stencil, at, sums);
        add_displacements<1>(runs, stencil, at, sums);
        add_displacements<2>(runs, stencil, at, sums);
        add_displacements<3>(runs, stencil, at, sums);
        add_displacements<4>(runs, stencil, at, sums);
        add_displacements<5>(runs, stencil, at, sums);
        add_displacements<6>(runs, stencil, at, sums);
        add_displacements<7>(runs, stencil, at, sums);
        float* const stress = at + simd::run_stress * runs.stride;
        store_components(runs, stress, sums.x, count);
        store_components(runs, stress + 3 * runs.stride, sums.y, count);
        store_components(runs, stress + 6 * runs.stride, sums.z, count);
        store_components(runs, at + simd::run_spring * runs.stride, sums.spring, count);
      },
      [&](int complete) PHYMUL_INLINED {
        float* at = runs.components + simd::run_stress * runs.stride + static_cast<std::int64_t>(complete) * lanes;
        const Columns Q =
            averaged_stress<Energy>(body, complete,
                                    {load_components(runs, at), load_components(runs, at + 3 * runs.stride),
                                     load_components(runs, at + 6 * runs.stride)});
        store_components(runs, at, Q.c0, lanes);
        store_components(runs, at + 3 * runs.stride, Q.c1, lanes);
        store_components(runs, at + 6 * runs.stride, Q.c2, lanes);
      });
}

inline void scale_run_stresses(const simd::Averaged& body, int slice, int end) {
  for (; slice < end; ++slice) {
    const std::int64_t at = std::int64_t{slice} * lanes;
    const Pack factor = load(body.factor + at);
    constexpr int rows[] = {simd::run_stress, simd::run_stress + 3, simd::run_stress + 6, simd::run_spring};
    for (const int row : rows) {
      float* const components = body.runs.components + row * body.runs.stride + at;
      store_components(body.runs, components, factor * load_components(body.runs, components), lanes);
    }
  }
}

inline void run_forces(const simd::Averaged& body, int slice, int end) {
  const simd::Runs& runs = body.runs;
  for_each_run(
      body, slice, end,
      [&](const simd::Stencil& stencil, float* at, std::int64_t count) PHYMUL_INLINED {
        Columns sums{};
        add_stresses<1>(runs, stencil, at, sums);
        add_stresses<2>(runs, stencil, at, sums);
        add_stresses<3>(runs, stencil, at, sums);
        add_stresses<4>(runs, stencil, at, sums);
        add_stresses<5>(runs, stencil, at, sums);
        add_stresses<6>(runs, stencil, at, sums);
        add_stresses<7>(runs, stencil, at, sums);
        store_components(runs, at + simd::run_force * runs.stride, sums.c0 + sums.c1 + sums.c2, count);
      },
      [&](int complete) PHYMUL_INLINED {
        const std::int64_t first = static_cast<std::int64_t>(complete) * lanes;
        const float* at = runs.components + first;
        store_row(body.force + 16 * first, load_components(runs, at + simd::run_spring * runs.stride) +
                                               load_components(runs, at + simd::run_force * runs.stride));
      });
}

// Stresses of materials that dissipate (elastic/dissipation.h), slice by slice.

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
