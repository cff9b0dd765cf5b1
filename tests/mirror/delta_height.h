// SPDX-License-Identifier: MIT
//
// Height scale of the area exponent, as a difference from rest. With s = |w| / |w at rest| and
// growth y = (s^2 - 1) / 2, which is 0 at rest and never below -1/2:
//   g(s) = [2 / (1 + s^2)]^p = (1 + y)^-p,   g - 1 = expm1(-p log1p(y)),   g'(s) = -p s g / (1 + y)
// The power is written here, from + - * and the bits of a float: pow() of a software renderer is a coarse polynomial.
// Exactly 0 at y = 0, else right to a few units in the last place of g - 1. Twin: glsl/kernels/delta_height.glsl.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "base/vector3.h"

namespace phymul::cpu {

// Packs overload these three.
inline std::int32_t float_bits(float x) {
  return std::bit_cast<std::int32_t>(x);
}
inline float bits_float(std::int32_t bits) {
  return std::bit_cast<float>(bits);
}
inline float whole_below(float x) {
  return std::floor(x);
}

/// Natural logarithm of 1 + y for y in [-1/2, 2^127).
template <class S>
S log_one_plus(const S& y) {
  // 1 + y = m 2^e with m in [0.70, 1.41). Near y = 0, m - 1 is y itself, without the rounding of 1 + y.
  const S a = S(1.0f) + y;
  const auto e = (float_bits(a) - 0x3f3504f3) >> 23;
  const S m = bits_float(float_bits(a) - (e << 23));
  const S x = select(e == 0, y, m - S(1.0f));
  const S t = x * (S(1.0f) / (S(2.0f) + x));
  const S t2 = t * t;
  // 2 atanh(t), |t| < 0.172
  const S series = S(0.6666667f) + t2 * (S(0.4f) + t2 * (S(0.28571429f) + t2 * S(0.22222222f)));
  const S log_m = S(2.0f) * t + t * (t2 * series);
  return S(0.693145751953125f) * S(e) + (log_m + S(1.4286068203e-6f) * S(e));
}

/// exp(z) - 1 for z up to 88; -1 far below 0.
template <class S>
S exp_minus_one(const S& z_in) {
  const S z = select(z_in < S(-80.0f), S(-80.0f), z_in);
  const S k = whole_below(z * S(1.442695f) + S(0.5f));
  // k times the upper part of ln 2 is exact: that has 15 bits.
  const S r = (z - k * S(0.693145751953125f)) - k * S(1.4286068203e-6f);
  const S tail =
      S(0.5f) + r * (S(0.16666667f) +
                     r * (S(0.041666668f) + r * (S(0.008333334f) + r * (S(0.0013888889f) + r * S(0.0001984127f)))));
  const S small = r + (r * r) * tail;
  const S power = bits_float((static_cast<std::int32_t>(k) + 127) << 23);
  return power * small + (power - S(1.0f));
}

template <class S>
struct DeltaHeight {
  S excess;  ///< g - 1
  S value;   ///< g
  S slope;   ///< g'(s)
};

template <class S>
DeltaHeight<S> delta_height(const S& growth, const S& s, const S& p) {
  const S excess = exp_minus_one(-(p * log_one_plus(growth)));
  const S value = S(1.0f) + excess;
  const S slope = -(p * s * value * (S(1.0f) / (S(1.0f) + growth)));
  return {excess, value, slope};
}

}  // namespace phymul::cpu
