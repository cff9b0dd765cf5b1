// SPDX-License-Identifier: MIT
//
// Attractors of particles that have nearly all triples j < k < l of their neighbours for bases: all lanes of a slice
// have their triples in one order, so that each neighbour is gathered once and a base costs two constants. Formulas as
// in base_terms.h.
#pragma once

#include "other_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

struct Neighbourhood {
  int count;
  const float* edges;    // per neighbour: offset, E (3), alpha
  const float* triples;  // per triple: w beta / |w0|, 1 / |w0|^2; 0 where there is no base
  Pack3 d[simd::most_enumerated], e[simd::most_enumerated];  // of the neighbours from the owner
  PHYMUL_INLINE Pack3 E(int k) const { return load3(edges + (5 * k + 1) * lanes); }
  PHYMUL_INLINE Pack alpha(int k) const { return load(edges + (5 * k + 4) * lanes); }
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

/// P* - x; keeps 1 / sqrt(a) - 1 of each triple where asked for. `neighbours`: how many there are, 0 where only the
/// neighbourhood knows.
template <bool keep, int neighbours>
PHYMUL_INLINE Pack3 enumerated_pull(const Neighbourhood& n, Pack* changes) {
  constexpr bool fixed = neighbours > 0;
  const int count = fixed ? neighbours : n.count;
  Pack3 sum{}, along{};
  for (int k = 0; k < count; ++k) along += n.alpha(k) * n.d[k];
  const float* row = n.triples;
  Pack3 E2[simd::most_enumerated], d2[simd::most_enumerated], e2[simd::most_enumerated];
  Pack length2[simd::most_enumerated];
  count_up<fixed, 0, neighbours - 2>(
      0, count - 2, [&](auto j_) __attribute__((always_inline)) {
        const int j = number(j_);
        constexpr int cj = number_of<decltype(j_)>;
        const Pack3 Ej = n.E(j), dj = n.d[j];
        count_up<fixed, cj + 1, neighbours>(
            j + 1, count, [&](auto l_) __attribute__((always_inline)) {
              const int l = number(l_);
              E2[l] = n.E(l) - Ej;
              d2[l] = n.d[l] - dj;
              e2[l] = E2[l] + d2[l];
              length2[l] = dot(e2[l], e2[l]);
            });
        count_up<fixed, cj + 1, neighbours - 1>(
            j + 1, count - 1, [&](auto k_) __attribute__((always_inline)) {
              const int k = number(k_);
              constexpr int ck = number_of<decltype(k_)>;
              const Pack3 E1 = E2[k], d1 = d2[k], e1 = e2[k];
              const Pack bound = collapsed * length2[k];
              count_up<fixed, ck + 1, neighbours>(
                  k + 1, count, [&](auto l_) __attribute__((always_inline)) {
                    const int l = number(l_);
                    prefetch_rows<2>(row);
                    const Pack rest = load(row + lanes);
                    const Pack3 w = cross(e1, e2[l]), dw = cross(d1, e2[l]) + cross(E1, d2[l]);
                    const Pack q = dot(w, w), y = dot(dw, w + (w - dw)) * rest;
                    const Pack c = select(q > bound * length2[l], inverse_root_change(q * rest, y), all(-1.0f));
                    sum += load(row) * (dw + c * w);
                    if constexpr (keep) *changes++ = c;
                    row += 2 * lanes;
                  });
            });
      });
  return along + sum;
}

/// What F costs the neighbours, as base_terms.h's give_back over all triples. The lambda of all bases together are
/// alpha.
template <int neighbours>
PHYMUL_INLINE void enumerated_give_back(const Neighbourhood& n, const Pack* changes, Pack3 F, char* force) {
  constexpr bool fixed = neighbours > 0;
  const int count = fixed ? neighbours : n.count;
  Pack3 f[simd::most_enumerated], e2[simd::most_enumerated];
  for (int k = 0; k < count; ++k) f[k] = -(n.alpha(k) * F);
  const float* row = n.triples;
  count_up<fixed, 0, neighbours - 2>(
      0, count - 2, [&](auto j_) __attribute__((always_inline)) {
        const int j = number(j_);
        constexpr int cj = number_of<decltype(j_)>;
        const Pack3 ej = n.e[j];
        count_up<fixed, cj + 1, neighbours>(
            j + 1, count, [&](auto l_) __attribute__((always_inline)) { e2[number(l_)] = n.e[number(l_)] - ej; });
        Pack3 fj{};
        count_up<fixed, cj + 1, neighbours - 1>(
            j + 1, count - 1, [&](auto k_) __attribute__((always_inline)) {
              const int k = number(k_);
              constexpr int ck = number_of<decltype(k_)>;
              const Pack3 e1 = e2[k];
              Pack3 fk{}, all_G{};
              count_up<fixed, ck + 1, neighbours>(
                  k + 1, count, [&](auto l_) __attribute__((always_inline)) {
                    const int l = number(l_);
                    const Pack rho = *changes++ + 1.0f;
                    const Pack3 w = cross(e1, e2[l]);
                    const Pack3 G = (load(row) * rho) * (F - (load(row + lanes) * rho * rho * dot(w, F)) * w);
                    fk -= cross(e2[l], G);
                    all_G += G;
                    f[l] -= cross(G, e1);
                    row += 2 * lanes;
                  });
              f[k] += fk;
              fj += cross(all_G, e1) - fk;
            });
        f[j] += fj;
      });
  for (int k = 0; k < count; ++k) {
    std::int32_t offset[lanes];
    __builtin_memcpy(offset, n.edges + 5 * k * lanes, sizeof offset);
    scatter_add(force, offset, f[k]);
  }
}

/// Works on one slice, whose neighbourhood is gathered.
template <bool averaged, int neighbours>
[[gnu::noinline]] void enumerated_slice(const simd::Job& job, int slice, const Neighbourhood& n) {
  Pack changes[neighbours > 0 ? 64 : simd::most_enumerated_triples];
  const Pack3 F = load(job.stiffness + slice * lanes) * enumerated_pull<averaged, neighbours>(n, changes);
  if constexpr (averaged) {
    enumerated_give_back<neighbours>(n, changes, F, job.force);
    add_row(job.force + 16 * lanes * slice, F);
  } else {
    store_row(job.pull + 16 * lanes * slice, F);
  }
}

template <bool averaged>
void enumerated_slices(const simd::Job& job) {
  Neighbourhood n;
  for (int slice = 0; slice < job.enumerated.count; ++slice) {
    n.count = job.enumerated.neighbours[slice];
    n.edges = job.enumerated.rows + static_cast<std::int64_t>(job.enumerated.first[slice]) * lanes;
    n.triples = n.edges + 5 * n.count * lanes;
    const Pack3 ui = gather_row(job.u + 16 * lanes * slice);
    for (int k = 0; k < n.count; ++k) {
      std::int32_t offset[lanes];
      __builtin_memcpy(offset, n.edges + 5 * k * lanes, sizeof offset);
      n.d[k] = gather(job.u, offset) - ui;
      n.e[k] = n.E(k) + n.d[k];
    }
    switch (n.count) {
      case 4:
        enumerated_slice<averaged, 4>(job, slice, n);
        break;
      case 5:
        enumerated_slice<averaged, 5>(job, slice, n);
        break;
      case 6:
        enumerated_slice<averaged, 6>(job, slice, n);
        break;
      default:
        enumerated_slice<averaged, 0>(job, slice, n);
    }
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
