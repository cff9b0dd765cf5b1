// SPDX-License-Identifier: MIT
//
// A particle of each lane with its neighbours, which all kernels of enumerated triples share.
#pragma once

#include "job.h"
#include "pack_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

inline constexpr int most_pairs = simd::most_enumerated * (simd::most_enumerated - 1) / 2;

/// Rows of constants as job.h has them. A place is where a neighbour is, seen from the owner.
struct Neighbourhood {
  int count;
  bool thin;                    // simd::thin_triples
  bool fresh;                   // its constants are in no cache
  const std::int32_t* offsets;  // per neighbour
  const float* edges;           // per neighbour: E (3), alpha, A (3)
  const float* pairs;           // per pair k < l: 2 H
  const float* triples;         // per triple: w beta / |w0|, 2 / |w0|^2; 0 where there is no base
  Pack3 half[simd::most_enumerated], middle[simd::most_enumerated];  // d / 2, E + d / 2: the place is their sum
  PHYMUL_INLINE const float* row(int k) const { return edges + simd::neighbour_columns * k * lanes; }
  PHYMUL_INLINE Pack3 E(int k) const { return load3(row(k)); }
  PHYMUL_INLINE Pack alpha(int k) const { return load(row(k) + 3 * lanes); }
  PHYMUL_INLINE Pack3 A(int k) const { return load3(row(k) + 4 * lanes); }
  PHYMUL_INLINE Pack3 place(int k) const { return middle[k] + half[k]; }
};

template <int value_>
struct Number {
  static constexpr int value = value_;
};

/// Calls with first, first + 1 ... last - 1: numbers of the compiler's where `fixed`, so that it keeps what they index
/// in registers.
template <bool fixed, int first, int last, class Call>
PHYMUL_INLINE void count_up(int from, int to, const Call& call) {
  if constexpr (!fixed) {
    PHYMUL_UNROLL(2)
    for (int k = from; k < to; ++k) call(k);
  } else if constexpr (first < last) {
    call(Number<first>{});
    count_up<true, first + 1, last>(0, 0, call);
  }
}
PHYMUL_INLINE constexpr int number(int k) {
  return k;
}
template <int value>
PHYMUL_INLINE constexpr int number(Number<value>) {
  return value;
}
template <class>
inline constexpr int number_of = 0;
template <int value>
inline constexpr int number_of<Number<value>> = value;

/// sum alpha_j d_j
PHYMUL_INLINE Pack3 along_neighbours(const Neighbourhood& n) {
  Pack3 sum{};
  for (int k = 0; k < n.count; ++k) sum += (n.alpha(k) + n.alpha(k)) * n.half[k];
  return sum;
}

}  // namespace phymul::cpu::PHYMUL_ISA
