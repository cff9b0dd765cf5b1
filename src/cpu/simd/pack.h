// SPDX-License-Identifier: MIT
//
// Packs of floats, one lane per particle, base or element. Compiled once per instruction set: PHYMUL_LANES is 4 (any
// machine), 8 (AVX2) or 16 (AVX-512), and everything stands in a namespace of that set, so that no linker can pick a
// function for a machine that lacks its instructions. For the same reason these files use nothing of the standard
// library but types.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "base/compiler.h"

namespace phymul::cpu::PHYMUL_ISA {

inline constexpr int lanes = PHYMUL_LANES;

using Pack = PHYMUL_VECTOR(float, 4 * PHYMUL_LANES);
using Ints = PHYMUL_VECTOR(std::int32_t, 4 * PHYMUL_LANES);
using Quad = PHYMUL_VECTOR(float, 16);

struct Pack3 {
  Pack x, y, z;
};

PHYMUL_INLINE Pack all(float value) {
  return value - Pack{};  // of a compiler's own broadcast; exact
}
PHYMUL_INLINE Pack select(Ints mask, Pack a, Pack b) {
  return mask ? a : b;
}
/// Whether a < b in some lane.
PHYMUL_INLINE bool any_below(Pack a, Pack b) {
#if PHYMUL_LANES == 16
  return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ) != 0;
#elif PHYMUL_LANES == 8
  return _mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_LT_OQ)) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_ps(_mm_cmplt_ps((__m128)a, (__m128)b)) != 0;
#else
  bool any = false;
  for (int k = 0; k < lanes; ++k) any |= a[k] < b[k];
  return any;
#endif
}
PHYMUL_INLINE Pack larger(Pack a, Pack b) {
  return a > b ? a : b;
}
PHYMUL_INLINE Pack smaller(Pack a, Pack b) {
  return a < b ? a : b;
}
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

PHYMUL_INLINE Pack3 operator+(Pack3 a, Pack3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
PHYMUL_INLINE Pack3 operator-(Pack3 a, Pack3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
PHYMUL_INLINE Pack3 operator-(Pack3 a) {
  return {-a.x, -a.y, -a.z};
}
PHYMUL_INLINE Pack3 operator*(Pack s, Pack3 a) {
  return {s * a.x, s * a.y, s * a.z};
}
PHYMUL_INLINE Pack3& operator+=(Pack3& a, Pack3 b) {
  return a = a + b;
}
PHYMUL_INLINE Pack3& operator-=(Pack3& a, Pack3 b) {
  return a = a - b;
}
PHYMUL_INLINE Pack dot(Pack3 a, Pack3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
PHYMUL_INLINE Pack3 cross(Pack3 a, Pack3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
PHYMUL_INLINE Pack3 load3(const float* from) {
  return {load(from), load(from + lanes), load(from + 2 * lanes)};
}

/// 1 / sqrt(x) to 12 bits or more; infinite at 0.
PHYMUL_INLINE Pack rough_inverse_root(Pack x) {
#if PHYMUL_LANES == 16
  return (Pack)_mm512_rsqrt14_ps((__m512)x);
#elif PHYMUL_LANES == 8
  return (Pack)_mm256_rsqrt_ps((__m256)x);
#elif defined(__SSE2__)
  return (Pack)_mm_rsqrt_ps((__m128)x);
#else
  Pack r;
  for (int k = 0; k < lanes; ++k) r[k] = 1.0f / PHYMUL_ROOT(x[k]);
  return r;
#endif
}

/// 1 / sqrt(x), right to two units in the last place; x > 0.
PHYMUL_INLINE Pack inverse_root(Pack x) {
  const Pack r = rough_inverse_root(x);
  const Pack residual = x * r * r - 1.0f;
  return r - r * residual * (0.5f - 0.375f * residual);
}

/// Up to this y = a - 1 inverse_root_change_near() may be taken.
inline constexpr float most_near = 3.0f;

/// 1 / sqrt(a) - 1 from a > 0 and y = a - 1, the latter without the rounding of a: right to a few units in the last
/// place of the result or 1e-10 (AVX-512: 1e-12), whichever is more, and exactly 0 at y = 0. One step of third order
/// from a rough root.
PHYMUL_INLINE Pack inverse_root_change_near(Pack a, Pack y) {
  const Pack r = rough_inverse_root(a), c = r - 1.0f;
  const Pack residual = a * (c * c + (c + c)) + y;  // a r^2 - 1
  return select(y == 0.0f, Pack{}, c - r * residual * (0.5f - 0.375f * residual));
}
/// The same for any y: far above 1, a would magnify the rounding of c.
PHYMUL_INLINE Pack inverse_root_change(Pack a, Pack y) {
  const Pack r = rough_inverse_root(a), c = r - 1.0f;
  const Pack residual = select(y > most_near, (a * r) * r - 1.0f, a * (c * c + (c + c)) + y);
  return select(y == 0.0f, Pack{}, c - r * residual * (0.5f - 0.375f * residual));
}
/// c, of a = 1 + y to the last bit, where y is not 0, and 0 there. AVX-512 has the rough root of 1 right (Intel
/// Software Developer's Manual, VRSQRT14PS), and then c is 0 by itself.
PHYMUL_INLINE Pack zero_at_rest(Pack y, Pack c) {
#if PHYMUL_LANES == 16
  static_cast<void>(y);
  return c;
#else
  return select(y == 0.0f, Pack{}, c);
#endif
}

#if PHYMUL_LANES == 16
PHYMUL_INLINE Pack quads(const char* base, const std::int32_t* offset, int k) {
  __m512 p = _mm512_castps128_ps512((__m128)load_quad(base + offset[k]));
  // Loads that write four lanes need no unit that moves lanes about, of which there are fewer.
  p = _mm512_mask_broadcast_f32x4(p, 0x00f0, (__m128)load_quad(base + offset[4 + k]));
  p = _mm512_mask_broadcast_f32x4(p, 0x0f00, (__m128)load_quad(base + offset[8 + k]));
  return (Pack)_mm512_mask_broadcast_f32x4(p, 0xf000, (__m128)load_quad(base + offset[12 + k]));
}
PHYMUL_INLINE void split_quads(Pack p, Quad to[4]) {
  to[0] = (Quad)_mm512_castps512_ps128((__m512)p);
  to[1] = (Quad)_mm512_extractf32x4_ps((__m512)p, 1);
  to[2] = (Quad)_mm512_extractf32x4_ps((__m512)p, 2);
  to[3] = (Quad)_mm512_extractf32x4_ps((__m512)p, 3);
}
#elif PHYMUL_LANES == 8
PHYMUL_INLINE Pack quads(const char* base, const std::int32_t* offset, int k) {
  const __m256 low = _mm256_castps128_ps256((__m128)load_quad(base + offset[k]));
  return (Pack)_mm256_insertf128_ps(low, (__m128)load_quad(base + offset[4 + k]), 1);
}
PHYMUL_INLINE void split_quads(Pack p, Quad to[2]) {
  to[0] = (Quad)_mm256_castps256_ps128((__m256)p);
  to[1] = (Quad)_mm256_extractf128_ps((__m256)p, 1);
}
#else
PHYMUL_INLINE Pack quads(const char* base, const std::int32_t* offset, int k) {
  return load_quad(base + offset[k]);
}
PHYMUL_INLINE void split_quads(Pack p, Quad to[1]) {
  to[0] = p;
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
#define PHYMUL_SHUFFLE(p, q, a, b, c, d) PHYMUL_SHUFFLED(p, q, PHYMUL_GROUPS(a, b, c, d))

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
