// SPDX-License-Identifier: MIT
//
// Packs of floats, one lane per particle, base or element. Compiled once per instruction set: PHYMUL_LANES is 4 (any
// machine, and NEON), 8 (AVX2) or 16 (AVX-512), and everything stands in a namespace of that set, so that no linker can
// pick a function for a machine that lacks its instructions. For the same reason these files use nothing of the
// standard library but types.
//
// Of one set, all compilers, systems and processors give the same bits: every operation is one of IEEE 754, and the
// text says which of them are merged.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include "base/compiler.h"

namespace phymul::cpu::PHYMUL_ISA {

inline constexpr int lanes = PHYMUL_LANES;

using Floats = PHYMUL_VECTOR(float, 4 * PHYMUL_LANES);
using Ints = PHYMUL_VECTOR(std::int32_t, 4 * PHYMUL_LANES);
using Quad = PHYMUL_VECTOR(float, 16);

struct Pack {
  Floats v;
  Pack() = default;
  PHYMUL_INLINE Pack(Floats all) : v(all) {}
  PHYMUL_INLINE Pack(float value) : v(value - Floats{}) {}  // of a compiler's own broadcast; exact
  PHYMUL_INLINE float operator[](int lane) const { return v[lane]; }
};

/// a b, or -a b, not yet rounded: a sum may merge with it.
template <bool negative>
struct Product {
  Pack a, b;
  PHYMUL_INLINE operator Pack() const { return negative ? -a.v * b.v : a.v * b.v; }
};

struct Pack3 {
  Pack x, y, z;
};
/// Of a number and a vector.
template <bool negative>
struct Product3 {
  Pack s;
  Pack3 a;
  PHYMUL_INLINE operator Pack3() const {
    return {Product<negative>{s, a.x}, Product<negative>{s, a.y}, Product<negative>{s, a.z}};
  }
};

// a b + c, a b - c, -a b + c, -a b - c: in one rounding where the set has such an instruction. The text says which
// products are merged with which sums; a compiler that chose by itself would give bits of its own.
#if PHYMUL_LANES == 16
#define PHYMUL_MERGED(name, instruction)                                             \
  PHYMUL_INLINE Pack name(Pack a, Pack b, Pack c) {                                  \
    return Floats(_mm512_##instruction##_ps((__m512)a.v, (__m512)b.v, (__m512)c.v)); \
  }
#elif PHYMUL_LANES == 8
#define PHYMUL_MERGED(name, instruction)                                             \
  PHYMUL_INLINE Pack name(Pack a, Pack b, Pack c) {                                  \
    return Floats(_mm256_##instruction##_ps((__m256)a.v, (__m256)b.v, (__m256)c.v)); \
  }
#endif
#if PHYMUL_LANES > 4
PHYMUL_MERGED(product_plus, fmadd)
PHYMUL_MERGED(product_minus, fmsub)
PHYMUL_MERGED(minus_product_plus, fnmadd)
PHYMUL_MERGED(minus_product_minus, fnmsub)
#undef PHYMUL_MERGED
#else
PHYMUL_INLINE Pack product_plus(Pack a, Pack b, Pack c) {
#if defined(PHYMUL_NEON)
  return Floats(vfmaq_f32((float32x4_t)c.v, (float32x4_t)a.v, (float32x4_t)b.v));
#else
  return a.v * b.v + c.v;
#endif
}
PHYMUL_INLINE Pack product_minus(Pack a, Pack b, Pack c) {
  return product_plus(a, b, -c.v);
}
PHYMUL_INLINE Pack minus_product_plus(Pack a, Pack b, Pack c) {
#if defined(PHYMUL_NEON)
  return Floats(vfmsq_f32((float32x4_t)c.v, (float32x4_t)a.v, (float32x4_t)b.v));
#else
  return c.v - a.v * b.v;
#endif
}
PHYMUL_INLINE Pack minus_product_minus(Pack a, Pack b, Pack c) {
  return minus_product_plus(a, b, -c.v);
}
#endif

PHYMUL_INLINE Pack operator+(Pack a, Pack b) {
  return a.v + b.v;
}
PHYMUL_INLINE Pack operator-(Pack a, Pack b) {
  return a.v - b.v;
}
PHYMUL_INLINE Pack operator-(Pack a) {
  return -a.v;
}
PHYMUL_INLINE Pack operator/(Pack a, Pack b) {
  return a.v / b.v;
}
PHYMUL_INLINE Product<false> operator*(Pack a, Pack b) {
  return {a, b};
}
template <bool negative>
PHYMUL_INLINE Product<!negative> operator-(Product<negative> p) {
  return {p.a, p.b};
}
template <bool negative>
PHYMUL_INLINE Pack operator+(Product<negative> p, Pack c) {
  return negative ? minus_product_plus(p.a, p.b, c) : product_plus(p.a, p.b, c);
}
template <bool negative>
PHYMUL_INLINE Pack operator-(Product<negative> p, Pack c) {
  return negative ? minus_product_minus(p.a, p.b, c) : product_minus(p.a, p.b, c);
}
template <bool negative>
PHYMUL_INLINE Pack operator+(Pack c, Product<negative> p) {
  return p + c;
}
template <bool negative>
PHYMUL_INLINE Pack operator-(Pack c, Product<negative> p) {
  return -p + c;
}
template <bool first, bool second>
PHYMUL_INLINE Pack operator+(Product<first> p, Product<second> q) {
  return p + Pack(q);
}
template <bool first, bool second>
PHYMUL_INLINE Pack operator-(Product<first> p, Product<second> q) {
  return p - Pack(q);
}
template <class Summand>
PHYMUL_INLINE Pack& operator+=(Pack& a, Summand b) {
  return a = a + b;
}
template <class Summand>
PHYMUL_INLINE Pack& operator-=(Pack& a, Summand b) {
  return a = a - b;
}

PHYMUL_INLINE Ints operator<(Pack a, Pack b) {
  return a.v < b.v;
}
PHYMUL_INLINE Ints operator>(Pack a, Pack b) {
  return a.v > b.v;
}
PHYMUL_INLINE Ints operator<=(Pack a, Pack b) {
  return a.v <= b.v;
}
PHYMUL_INLINE Ints operator==(Pack a, Pack b) {
  return a.v == b.v;
}

PHYMUL_INLINE Pack all(float value) {
  return value;
}
PHYMUL_INLINE Pack select(Ints mask, Pack a, Pack b) {
  return mask ? a.v : b.v;
}
PHYMUL_INLINE Pack3 select(Ints mask, Pack3 a, Pack3 b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
/// Whether a < b in some lane.
PHYMUL_INLINE bool any_below(Pack a, Pack b) {
#if PHYMUL_LANES == 16
  return _mm512_cmp_ps_mask((__m512)a.v, (__m512)b.v, _CMP_LT_OQ) != 0;
#elif PHYMUL_LANES == 8
  return _mm256_movemask_ps(_mm256_cmp_ps((__m256)a.v, (__m256)b.v, _CMP_LT_OQ)) != 0;
#elif defined(__SSE2__)
  return _mm_movemask_ps(_mm_cmplt_ps((__m128)a.v, (__m128)b.v)) != 0;
#else
  bool any = false;
  for (int k = 0; k < lanes; ++k) any |= a[k] < b[k];
  return any;
#endif
}
PHYMUL_INLINE Pack larger(Pack a, Pack b) {
  return select(a > b, a, b);
}
PHYMUL_INLINE Pack smaller(Pack a, Pack b) {
  return select(a < b, a, b);
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
PHYMUL_INLINE Product3<false> operator*(Pack s, Pack3 a) {
  return {s, a};
}
template <bool negative>
PHYMUL_INLINE Product3<!negative> operator-(Product3<negative> p) {
  return {p.s, p.a};
}
template <bool negative>
PHYMUL_INLINE Pack3 operator+(Product3<negative> p, Pack3 c) {
  using Part = Product<negative>;
  return {Part{p.s, p.a.x} + c.x, Part{p.s, p.a.y} + c.y, Part{p.s, p.a.z} + c.z};
}
template <bool negative>
PHYMUL_INLINE Pack3 operator-(Product3<negative> p, Pack3 c) {
  using Part = Product<negative>;
  return {Part{p.s, p.a.x} - c.x, Part{p.s, p.a.y} - c.y, Part{p.s, p.a.z} - c.z};
}
template <bool negative>
PHYMUL_INLINE Pack3 operator+(Pack3 c, Product3<negative> p) {
  return p + c;
}
template <bool negative>
PHYMUL_INLINE Pack3 operator-(Pack3 c, Product3<negative> p) {
  return -p + c;
}
template <bool first, bool second>
PHYMUL_INLINE Pack3 operator+(Product3<first> p, Product3<second> q) {
  return p + Pack3(q);
}
template <bool first, bool second>
PHYMUL_INLINE Pack3 operator-(Product3<first> p, Product3<second> q) {
  return p - Pack3(q);
}
template <class Summand>
PHYMUL_INLINE Pack3& operator+=(Pack3& a, Summand b) {
  return a = a + b;
}
template <class Summand>
PHYMUL_INLINE Pack3& operator-=(Pack3& a, Summand b) {
  return a = a - b;
}
PHYMUL_INLINE Pack dot(Pack3 a, Pack3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
PHYMUL_INLINE Pack3 cross(Pack3 a, Pack3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Rounded correctly, as all of these are: rough roots of processors differ from maker to maker.
PHYMUL_INLINE Pack root(Pack x) {
#if PHYMUL_LANES == 16
  return Floats(_mm512_sqrt_ps((__m512)x.v));
#elif PHYMUL_LANES == 8
  return Floats(_mm256_sqrt_ps((__m256)x.v));
#elif defined(__SSE2__)
  return Floats(_mm_sqrt_ps((__m128)x.v));
#elif defined(__aarch64__)
  return Floats(vsqrtq_f32((float32x4_t)x.v));
#else
  Floats r;
  for (int k = 0; k < lanes; ++k) r[k] = PHYMUL_ROOT(x[k]);
  return r;
#endif
}

/// 1 / sqrt(x), x > 0.
PHYMUL_INLINE Pack inverse_root(Pack x) {
  return all(1.0f) / root(x);
}

/// 1 / sqrt(a) - 1 from a > 0 and y = a - 1, the latter without the rounding of a: right to a few units in the last
/// place, and 0 at y = 0.
PHYMUL_INLINE Pack inverse_root_change(Pack a, Pack y) {
  return -(y / (a + root(a)));
}

}  // namespace phymul::cpu::PHYMUL_ISA
