// SPDX-License-Identifier: MIT
//
// Packs from memory and back: rows of lanes, and vectors of four floats that lanes name by their offsets.
#pragma once

#include "pack.h"

namespace phymul::cpu::PHYMUL_ISA {

PHYMUL_INLINE Pack load(const float* from) {
  Pack p;
  PHYMUL_COPY(&p, from, sizeof p);
  return p;
}
PHYMUL_INLINE void store(float* to, Pack p) {
  PHYMUL_COPY(to, &p, sizeof p);
}
PHYMUL_INLINE Quad load_quad(const char* from) {
  Quad q;
  PHYMUL_COPY(&q, PHYMUL_ALIGNED(from, 16), sizeof q);
  return q;
}
PHYMUL_INLINE void store_quad(char* to, Quad q) {
  PHYMUL_COPY(PHYMUL_ALIGNED(to, 16), &q, sizeof q);
}

/// Asks for what a pass over rows of `columns` will read some 4 kB later: from memory, not from a cache, it would come
/// too late, because the processor's own foresight ends with a page.
template <int columns>
PHYMUL_INLINE void prefetch_rows(const float* row) {
  constexpr int ahead = 1024;
  for (int k = 0; k < columns * lanes; k += 16) PHYMUL_PREFETCH(row + ahead + k);
}
PHYMUL_INLINE Pack3 load3(const float* from) {
  return {load(from), load(from + lanes), load(from + 2 * lanes)};
}

#if PHYMUL_LANES == 16
PHYMUL_INLINE Pack quads(const char* base, const std::int32_t* offset, int k) {
  __m512 p = _mm512_castps128_ps512((__m128)load_quad(base + offset[k]));
  // Loads that write four lanes need no unit that moves lanes about, of which there are fewer.
  p = _mm512_mask_broadcast_f32x4(p, 0x00f0, (__m128)load_quad(base + offset[4 + k]));
  p = _mm512_mask_broadcast_f32x4(p, 0x0f00, (__m128)load_quad(base + offset[8 + k]));
  return Floats(_mm512_mask_broadcast_f32x4(p, 0xf000, (__m128)load_quad(base + offset[12 + k])));
}
PHYMUL_INLINE void split_quads(Pack p, Quad to[4]) {
  to[0] = (Quad)_mm512_castps512_ps128((__m512)p.v);
  to[1] = (Quad)_mm512_extractf32x4_ps((__m512)p.v, 1);
  to[2] = (Quad)_mm512_extractf32x4_ps((__m512)p.v, 2);
  to[3] = (Quad)_mm512_extractf32x4_ps((__m512)p.v, 3);
}
#elif PHYMUL_LANES == 8
PHYMUL_INLINE Pack quads(const char* base, const std::int32_t* offset, int k) {
  const __m256 low = _mm256_castps128_ps256((__m128)load_quad(base + offset[k]));
  return Floats(_mm256_insertf128_ps(low, (__m128)load_quad(base + offset[4 + k]), 1));
}
PHYMUL_INLINE void split_quads(Pack p, Quad to[2]) {
  to[0] = (Quad)_mm256_castps256_ps128((__m256)p.v);
  to[1] = (Quad)_mm256_extractf128_ps((__m256)p.v, 1);
}
#else
PHYMUL_INLINE Pack quads(const char* base, const std::int32_t* offset, int k) {
  return load_quad(base + offset[k]);
}
PHYMUL_INLINE void split_quads(Pack p, Quad to[1]) {
  to[0] = p.v;
}
#endif

// Unpacks within groups of four lanes.
#if PHYMUL_LANES == 16
#define PHYMUL_GROUPS(a, b, c, d)                                                                                 \
  (a), (b), (c), (d), (a) + 4, (b) + 4, (c) + 4, (d) + 4, (a) + 8, (b) + 8, (c) + 8, (d) + 8, (a) + 12, (b) + 12, \
      (c) + 12, (d) + 12
#elif PHYMUL_LANES == 8
#define PHYMUL_GROUPS(a, b, c, d) (a), (b), (c), (d), (a) + 4, (b) + 4, (c) + 4, (d) + 4
#else
#define PHYMUL_GROUPS(a, b, c, d) (a), (b), (c), (d)
#endif
#define PHYMUL_SHUFFLE(p, q, a, b, c, d) Pack(PHYMUL_SHUFFLED((p).v, (q).v, PHYMUL_GROUPS(a, b, c, d)))

struct FourPacks {
  Pack p[4];
};

/// Turns the 4 x 4 blocks of four packs over.
PHYMUL_INLINE FourPacks transposed(FourPacks in) {
  constexpr int n = lanes;
  const Pack low01 = PHYMUL_SHUFFLE(in.p[0], in.p[1], 0, n, 1, n + 1);
  const Pack high01 = PHYMUL_SHUFFLE(in.p[0], in.p[1], 2, n + 2, 3, n + 3);
  const Pack low23 = PHYMUL_SHUFFLE(in.p[2], in.p[3], 0, n, 1, n + 1);
  const Pack high23 = PHYMUL_SHUFFLE(in.p[2], in.p[3], 2, n + 2, 3, n + 3);
  return {{PHYMUL_SHUFFLE(low01, low23, 0, 1, n, n + 1), PHYMUL_SHUFFLE(low01, low23, 2, 3, n + 2, n + 3),
           PHYMUL_SHUFFLE(high01, high23, 0, 1, n, n + 1), PHYMUL_SHUFFLE(high01, high23, 2, 3, n + 2, n + 3)}};
}

/// Vectors of four floats at byte offsets `offset` [lanes] from base.
PHYMUL_INLINE Pack3 gather(const char* base, const std::int32_t* offset) {
  const FourPacks t =
      transposed({{quads(base, offset, 0), quads(base, offset, 1), quads(base, offset, 2), quads(base, offset, 3)}});
  return {t.p[0], t.p[1], t.p[2]};
}

/// A slice's vectors, which stand as simd::quad_of() has them.
PHYMUL_INLINE FourPacks load_row(const char* base) {
  FourPacks row;
  for (int k = 0; k < 4; ++k) PHYMUL_COPY(&row.p[k], base + 4 * lanes * k, sizeof(Pack));
  return row;
}
PHYMUL_INLINE Pack3 gather_row(const char* base) {
  const FourPacks t = transposed(load_row(base));
  return {t.p[0], t.p[1], t.p[2]};
}
PHYMUL_INLINE void store_row(char* base, Pack3 v) {
  const FourPacks t = transposed({{v.x, v.y, v.z, Pack{}}});
  for (int k = 0; k < 4; ++k) PHYMUL_COPY(base + 4 * lanes * k, &t.p[k], sizeof(Pack));
}
PHYMUL_INLINE void add_row(char* base, Pack3 v) {
  const FourPacks now = load_row(base), t = transposed({{v.x, v.y, v.z, Pack{}}});
  for (int k = 0; k < 4; ++k) {
    const Pack sum = now.p[k] + t.p[k];
    PHYMUL_COPY(base + 4 * lanes * k, &sum, sizeof sum);
  }
}

/// Calls with (lane, vector of four floats) of each lane.
template <class Take>
PHYMUL_INLINE void for_each_quad(Pack3 v, const Take& take) {
  const FourPacks t = transposed({{v.x, v.y, v.z, Pack{}}});
  for (int k = 0; k < 4; ++k) {
    Quad q[lanes / 4];
    split_quads(t.p[k], q);
    for (int group = 0; group < lanes / 4; ++group) take(4 * group + k, q[group]);
  }
}

/// Adds lane by lane, in a fixed order: two lanes may mean one place.
PHYMUL_INLINE void scatter_add(char* base, const std::int32_t* offset, Pack3 v) {
  for_each_quad(v, [&](int lane, Quad q) PHYMUL_INLINED {
    char* at = base + offset[lane];
    store_quad(at, load_quad(at) + q);
  });
}

}  // namespace phymul::cpu::PHYMUL_ISA
