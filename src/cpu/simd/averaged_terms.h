// SPDX-License-Identifier: MIT
//
// Law::particle_averaged, in two passes over the domains: the stress of each from the displacements around it, then its
// force from the stresses around it. A link costs a load of what is gathered, one of its constants, and one product of
// sixteen floats: four copies of a vector of displacement, times x, y, z and the stiffness of the link, or the three
// columns of a stress times x, y and z.
#pragma once

#include "job.h"
#include "kernel_text.h"
#include "pack_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

/// Four vectors of four floats.
#if PHYMUL_LANES == 16
struct Wide {
  __m512 all;
};
PHYMUL_INLINE Wide zero_wide() {
  return {_mm512_setzero_ps()};
}
PHYMUL_INLINE Wide load_wide(const char* from) {
  return {_mm512_load_ps(reinterpret_cast<const float*>(from))};
}
PHYMUL_INLINE Wide four_times(Quad q) {
  return {_mm512_broadcast_f32x4((__m128)q)};
}
/// x, x, x, x, y, y, y, y, z, ...
PHYMUL_INLINE Wide each_four_times(const float* from) {
  const __m512 q = _mm512_broadcast_f32x4(_mm_load_ps(from));
  return {_mm512_permutevar_ps(q, _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0))};
}
PHYMUL_INLINE Wide plus_product(Wide sum, Wide a, Wide b) {
  return {_mm512_fmadd_ps(a.all, b.all, sum.all)};
}
PHYMUL_INLINE Wide plus(Wide a, Wide b) {
  return {_mm512_add_ps(a.all, b.all)};
}
PHYMUL_INLINE void split(Wide w, Quad to[4]) {
  split_quads(Floats(w.all), to);
}
#elif PHYMUL_LANES == 8
struct Wide {
  __m256 low, high;
};
PHYMUL_INLINE Wide zero_wide() {
  return {_mm256_setzero_ps(), _mm256_setzero_ps()};
}
PHYMUL_INLINE Wide load_wide(const char* from) {
  const float* at = reinterpret_cast<const float*>(from);
  return {_mm256_load_ps(at), _mm256_load_ps(at + 8)};
}
PHYMUL_INLINE Wide four_times(Quad q) {
  const __m256 twice = _mm256_set_m128((__m128)q, (__m128)q);
  return {twice, twice};
}
/// x, x, x, x, y, y, y, y, z, ...
PHYMUL_INLINE Wide each_four_times(const float* from) {
  const __m256 q = _mm256_broadcast_ps(reinterpret_cast<const __m128*>(from));
  return {_mm256_permutevar_ps(q, _mm256_set_epi32(1, 1, 1, 1, 0, 0, 0, 0)),
          _mm256_permutevar_ps(q, _mm256_set_epi32(3, 3, 3, 3, 2, 2, 2, 2))};
}
PHYMUL_INLINE Wide plus_product(Wide sum, Wide a, Wide b) {
  return {_mm256_fmadd_ps(a.low, b.low, sum.low), _mm256_fmadd_ps(a.high, b.high, sum.high)};
}
PHYMUL_INLINE Wide plus(Wide a, Wide b) {
  return {_mm256_add_ps(a.low, b.low), _mm256_add_ps(a.high, b.high)};
}
PHYMUL_INLINE void split(Wide w, Quad to[4]) {
  split_quads(Floats(w.low), to);
  split_quads(Floats(w.high), to + 2);
}
#else
struct Wide {
  Quad q[4];
};
PHYMUL_INLINE Wide zero_wide() {
  return {};
}
PHYMUL_INLINE Wide load_wide(const char* from) {
  return {{load_quad(from), load_quad(from + 16), load_quad(from + 32), load_quad(from + 48)}};
}
PHYMUL_INLINE Wide four_times(Quad q) {
  return {{q, q, q, q}};
}
/// x, x, x, x, y, y, y, y, z, ...
PHYMUL_INLINE Wide each_four_times(const float* from) {
  return {{Quad{} + from[0], Quad{} + from[1], Quad{} + from[2], Quad{} + from[3]}};
}
PHYMUL_INLINE Wide plus_product(Wide sum, Wide a, Wide b) {
  for (int k = 0; k < 4; ++k) sum.q[k] = product_plus(a.q[k], b.q[k], sum.q[k]).v;
  return sum;
}
PHYMUL_INLINE Wide plus(Wide a, Wide b) {
  for (int k = 0; k < 4; ++k) a.q[k] += b.q[k];
  return a;
}
PHYMUL_INLINE void split(Wide w, Quad to[4]) {
  for (int k = 0; k < 4; ++k) to[k] = w.q[k];
}
#endif

/// Slots ahead of a pass at which it asks for what it will gather: farther than nearly all links reach, or else the
/// first of them to reach a line waits for it.
inline constexpr std::int64_t gathered_ahead = 1024;

/// Sum over the links of slot q, of which there is an even number: two sums, whose products need not wait for each
/// other. `gathered`: of a byte offset in Averaged::u, from `from` plus `scale` times it.
template <int scale, class Gathered>
PHYMUL_INLINE Wide link_sum(const simd::Averaged& body, std::int64_t q, const std::int32_t* rows, const char* from,
                            const Gathered& gathered) {
  Wide even = zero_wide(), odd = zero_wide();
  const float* constants = body.links + 4 * static_cast<std::int64_t>(rows[q]);
  const std::int32_t *link = body.link + body.link_range[2 * q], *last = body.link + body.link_range[2 * q + 1];
  for (; link < last; link += 2, constants += 8) {
    if (body.far) {
      PHYMUL_PREFETCH(constants + 4 * simd::links_ahead);
      for (int k = 0; k < 2; ++k) {
        PHYMUL_PREFETCH(from + scale * static_cast<std::int64_t>(link[simd::links_ahead + k]));
      }
    }
    even = plus_product(even, gathered(link[0]), each_four_times(constants));
    odd = plus_product(odd, gathered(link[1]), each_four_times(constants + 4));
  }
  return plus(even, odd);
}

PHYMUL_INLINE void store_columns(float* to, const Columns& A) {
  const Pack part[9] = {A.c0.x, A.c0.y, A.c0.z, A.c1.x, A.c1.y, A.c1.z, A.c2.x, A.c2.y, A.c2.z};
  for (int k = 0; k < 9; ++k) store(to + k * lanes, part[k]);
}

/// Stresses of slice `slice` from its sums of displacements times areas, without what is left of z in a plane.
template <class Energy>
PHYMUL_INLINE Columns averaged_stress(const simd::Averaged& body, int slice, const Columns& sums) {
  const float* constants = body.constants + static_cast<std::int64_t>(slice) * (2 + Energy::energy_constants) * lanes;
  const Pack inverse_volume = load(constants), spread = load(constants + lanes);
  Pack p[Energy::energy_constants];
  for (int k = 0; k < Energy::energy_constants; ++k) p[k] = load(constants + (2 + k) * lanes);
  if (body.sums) store_columns(body.sums + static_cast<std::int64_t>(slice) * 9 * lanes, sums);
  const Columns H = Energy::scaled(inverse_volume, sums);
  const Columns P = Energy::energy_stress(H, p);
  float* const condition =
      body.condition == nullptr ? nullptr : body.condition + static_cast<std::int64_t>(slice) * lanes;
  if constexpr (requires { Energy::energy_condition(H, p); }) {
    if (condition) store(condition, Energy::energy_condition(H, p));
  } else if constexpr (requires { Energy::squared_condition(H, Energy::change_of(H)); }) {
    if (condition) store(condition, Energy::squared_condition(H, Energy::change_of(H)));
  }
  Columns Q{P.c0 - spread * H.c0, P.c1 - spread * H.c1, P.c2 - spread * H.c2};
  if (body.plane) Q.c0.z = Q.c1.z = Q.c2.z = Pack{};  // nothing but rounding, which would leave the plane
  return Q;
}

/// Displacements that later slices gather, and where the stresses of the next few go.
PHYMUL_INLINE void ask_for_slice(const simd::Averaged& body, std::int64_t first) {
  for (int k = 0; k < lanes; k += 4) PHYMUL_PREFETCH(body.u + 16 * (first + gathered_ahead + k));
  for (int k = 0; k < lanes; ++k) PHYMUL_PREFETCH_TO_WRITE(body.stress + 64 * (first + 4 * lanes + k));
}

/// Stresses and springs of slices [slice, end). Displacements around a slot, each less its own, are summed with the
/// areas (three columns) and with the stiffnesses (the fourth).
template <class Energy>
void averaged_stresses(const simd::Averaged& body, int slice, int end) {
  alignas(64) float columns[3][4 * lanes];
  for (; slice < end; ++slice) {
    const std::int64_t first = static_cast<std::int64_t>(slice) * lanes;
    if (body.far) ask_for_slice(body, first);
    for (int k = 0; k < lanes; ++k) {
      const Quad own = load_quad(body.u + 16 * (first + k));
      Quad sum[4];
      split(
          link_sum<1>(body, first + k, body.stress_row, body.u,
                      [&](std::int32_t offset) PHYMUL_INLINED { return four_times(load_quad(body.u + offset) - own); }),
          sum);
      for (int c = 0; c < 3; ++c) store_quad(reinterpret_cast<char*>(columns[c]) + 16 * k, sum[c]);
      store_quad(body.force + 16 * (first + k), sum[3]);
    }
    const Columns Q = averaged_stress<Energy>(
        body, slice,
        {gather_row(reinterpret_cast<const char*>(columns[0])), gather_row(reinterpret_cast<const char*>(columns[1])),
         gather_row(reinterpret_cast<const char*>(columns[2]))});
    const Pack3 column[3] = {Q.c0, Q.c1, Q.c2};
    for (int c = 0; c < 3; ++c) {
      char* to = body.stress + 64 * first + 16 * c;
      for_each_quad(column[c],
                    [&](int lane, Quad q) PHYMUL_INLINED { store_quad(to + 64 * simd::quad_of(lane, lanes), q); });
    }
  }
}

/// Stresses and springs of slices [slice, end), times Averaged::factor.
inline void scale_stresses(const simd::Averaged& body, int slice, int end) {
  for (std::int64_t place = std::int64_t{slice} * lanes; place < std::int64_t{end} * lanes; ++place) {
    const std::int64_t q = place / lanes * lanes + simd::quad_of(static_cast<std::int32_t>(place % lanes), lanes);
    const Quad factor = Quad{} + body.factor[place];
    for (int c = 0; c < 3; ++c) {
      char* const at = body.stress + 64 * q + 16 * c;
      store_quad(at, factor * load_quad(at));
    }
    store_quad(body.force + 16 * q, factor * load_quad(body.force + 16 * q));
  }
}

/// Forces of slices [slice, end), added to the springs'.
inline void averaged_forces(const simd::Averaged& body, int slice, int end) {
  const std::int64_t last = static_cast<std::int64_t>(end) * lanes;
  for (std::int64_t q = static_cast<std::int64_t>(slice) * lanes; q < last; ++q) {
    if (body.far) PHYMUL_PREFETCH(body.stress + 64 * (q + gathered_ahead));
    Quad part[4];
    split(link_sum<4>(body, q, body.force_row, body.stress,
                      [&](std::int32_t offset)
                          PHYMUL_INLINED { return load_wide(body.stress + 4 * static_cast<std::int64_t>(offset)); }),
          part);
    char* at = body.force + 16 * q;
    store_quad(at, load_quad(at) + ((part[0] + part[1]) + part[2]));
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
