// SPDX-License-Identifier: MIT
//
// A root by operations that IEEE 754 defines to the last bit: std::pow and std::cbrt round as each C library likes.
#pragma once

#include <bit>
#include <cstdint>

namespace phymul {

/// a^(-1/3), a > 0, to 1e-15 of it; exactly 1 at 1.
inline double inverse_cube_root(double a) {
  // The exponent, and with it the logarithm, stands in the first bits: minus a third of it, from 1, is 6 % off at most.
  constexpr std::uint64_t one = std::bit_cast<std::uint64_t>(1.0);
  double x = std::bit_cast<double>(one + one / 3 - std::bit_cast<std::uint64_t>(a) / 3);
  // x (1 - h)^(-1/3) is the root; three terms of that series leave an error of 0.2 h^3: 1e-3, 1e-8, then rounding.
  for (int k = 0; k < 3; ++k) {
    const double h = 1.0 - (a * x) * (x * x);
    x += x * h * (1.0 / 3.0 + (2.0 / 9.0) * h);
  }
  return x;
}

}  // namespace phymul
