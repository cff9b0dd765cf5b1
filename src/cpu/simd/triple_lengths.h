// SPDX-License-Identifier: MIT
//
// Enumerated triples by the lengths of their edges: pairs of neighbours are far fewer than triples, and what a triple
// needs of them are scalars. Of the edge between neighbours k and l, with its halves of the displacement and its place
// in the middle of its way (h = d / 2, m = E + h):
//   eta = h.m = (|e|^2 - |E|^2) / 4,   g = |m|^2 + |h|^2 = (|e|^2 + |E|^2) / 2
// Of a triple with edges 1, 2 from its first neighbour and 3 between the others, |w|^2 = |e1|^2 |e2|^2 - (e1.e2)^2 and
// 2 e1.e2 = |e1|^2 + |e2|^2 - |e3|^2 give the change of its area, which is 0 with eta:
//   y = |w|^2 / |w0|^2 - 1 = 2 / |w0|^2 (2 eta1 g2 + 2 g1 eta2 - (eta1 + eta2 - eta3) (g1 + g2 - g3))
// Normals are not needed one by one. With h_t = w_t beta_t / |w0|, c_t = 1 / sqrt(1 + y) - 1 and places x_k,
//   sum h_t |w0| (n - n0) = sum h_t dw + sum h_t c_t w
// where w = x_j x x_k + x_k x x_l + x_l x x_j makes both sums over pairs, with the scalars H_kl = 2 sum of +- h_t and
// S_kl = sum of +- h_t c_t. As x_k x x_l = E_k x E_l at rest and x = E + 2 h, the first is
//   sum over k < l of H (E_k x h_l + h_k x E_l + 2 h_k x h_l) = sum over k of h_k x (A_k + sum over l > k of 2 H h_l)
// with constants A_k = sum over l > k of H_kl E_l - sum over l < k of H_lk E_l.
// What it costs: y is rounded as by 1 / sin^2 of the angle between edges 1 and 2 where pull_by_normals() has 1 / sin,
// and a triple is taken only as long as its edges and area are within bounds.
#pragma once

#include "neighbourhood.h"

namespace phymul::cpu::PHYMUL_ISA {

using simd::pairs_of;

/// Where a triangle has less of its area at rest, squared, its y has lost too many digits.
inline constexpr float least_area_squared = 0.0625f;
/// Edges that hardly change may open a flat triangle to any multiple of its area.
inline constexpr float most_area_squared = 16.0f;
/// eta / g up to which an edge is taken: twice its length.
inline constexpr float most_stretch = 0.3f;

/// Scalars of the pairs k < l of so many neighbours; 0: as many as there can be.
template <int neighbours>
using Pairs = Pack[neighbours > 0 ? neighbours*(neighbours - 1) / 2 : most_pairs];

template <int neighbours>
struct PairLengths {
  Pairs<neighbours> eta, g;
  Pairs<neighbours> S;  // 0 at first
};

/// Returns whether no edge is longer than bounds allow.
template <int neighbours>
PHYMUL_INLINE bool measure_pairs(const Neighbourhood& n, PairLengths<neighbours>& pairs) {
  constexpr bool fixed = neighbours > 0;
  const int count = fixed ? neighbours : n.count;
  Pack farthest = all(-1.0f);
  count_up<fixed, 0, neighbours - 1>(0, count - 1, [&](auto j_) PHYMUL_INLINED {
    const int j = number(j_), first = pairs_of(count, j);
    constexpr int cj = number_of<decltype(j_)>;
    const Pack3 hj = n.half[j], mj = n.middle[j];
    count_up<fixed, cj + 1, neighbours>(j + 1, count, [&](auto l_) PHYMUL_INLINED {
      const int l = number(l_);
      const Pack3 h = n.half[l] - hj, m = n.middle[l] - mj;
      const Pack eta = dot(h, m), g = dot(m, m) + dot(h, h);
      pairs.eta[first + l] = eta;
      pairs.g[first + l] = g;
      pairs.S[first + l] = Pack{};
      farthest = larger(eta - most_stretch * g, farthest);
    });
  });
  return !any_below(Pack{}, farthest);
}

/// P* - x; keeps c of each triple where asked for. False, and nothing of use, where a triple is out of bounds.
/// `neighbours`: how many there are, 0 where only the neighbourhood knows.
template <bool keep, int neighbours>
PHYMUL_INLINE bool pull_by_lengths(const Neighbourhood& n, PairLengths<neighbours>& pairs, Pack* changes, Pack3& pull) {
  constexpr bool fixed = neighbours > 0;
  const int count = fixed ? neighbours : n.count;
  if (!measure_pairs<neighbours>(n, pairs)) return false;
  Pairs<neighbours>& S = pairs.S;
  const float* row = n.triples;
  Pack least = all(1.0f), most = all(-1.0f);
  count_up<fixed, 0, neighbours - 2>(0, count - 2, [&](auto j_) PHYMUL_INLINED {
    const int j = number(j_), of_j = pairs_of(count, j);
    constexpr int cj = number_of<decltype(j_)>;
    count_up<fixed, cj + 1, neighbours - 1>(j + 1, count - 1, [&](auto k_) PHYMUL_INLINED {
      const int k = number(k_), of_k = pairs_of(count, k);
      constexpr int ck = number_of<decltype(k_)>;
      const Pack eta1 = pairs.eta[of_j + k], g1 = pairs.g[of_j + k];
      const Pack twice_eta1 = eta1 + eta1, twice_g1 = g1 + g1;
      Pack S1 = S[of_j + k];
      count_up<fixed, ck + 1, neighbours>(k + 1, count, [&](auto l_) PHYMUL_INLINED {
        const int jl = of_j + number(l_), kl = of_k + number(l_);
        if (!fixed && n.fresh) prefetch_rows<2>(row);
        const Pack eta2 = pairs.eta[jl], g2 = pairs.g[jl];
        const Pack eta = (eta1 + eta2) - pairs.eta[kl], g = (g1 + g2) - pairs.g[kl];
        const Pack y = load(row + lanes) * ((twice_eta1 * g2 + twice_g1 * eta2) - eta * g);
        least = smaller(y, least);
        most = larger(y, most);
        const Pack c = inverse_root_change(y + 1.0f, y);
        if constexpr (keep) *changes++ = c;
        const auto share = load(row) * c;
        S1 += share;
        S[jl] -= share;
        S[kl] += share;
        row += 2 * lanes;
      });
      S[of_j + k] = S1;
    });
  });
  pull = along_neighbours(n);
  const float* height = n.pairs;
  count_up<fixed, 0, neighbours - 1>(0, count - 1, [&](auto j_) PHYMUL_INLINED {
    const int j = number(j_), first = pairs_of(count, j);
    constexpr int cj = number_of<decltype(j_)>;
    Pack3 turning{}, tilting = n.A(j);
    count_up<fixed, cj + 1, neighbours>(j + 1, count, [&](auto l_) PHYMUL_INLINED {
      const int l = number(l_);
      const Pack H = load(height);
      turning += S[first + l] * n.place(l);
      tilting += H * n.half[l];
      height += lanes;
    });
    pull += cross(n.place(j), turning) + cross(n.half[j], tilting);
  });
  if (fixed || count > 0) pull += cross(n.half[count - 1], n.A(count - 1));
  return !any_below(least, all(least_area_squared - 1.0f)) && !any_below(all(most_area_squared - 1.0f), most);
}

/// What F costs the neighbours. Of G = h_t rho (F - n (n.F)), the derivative by w, rho = 1 + c, the first part makes
/// forces S_kl x_l x F on neighbour k, and the second, along w, makes forces along the edges, T_kl (x_k - x_l).
template <int neighbours>
PHYMUL_INLINE void give_back_by_lengths(const Neighbourhood& n, PairLengths<neighbours>& pairs, const Pack* changes,
                                        Pack3 F, char* force) {
  constexpr bool fixed = neighbours > 0;
  const int count = fixed ? neighbours : n.count;
  Pack3 place[simd::most_enumerated];
  Pairs<neighbours> volume, S, T;  // F.(x_k x x_l)
  for (int k = 0; k < count; ++k) place[k] = n.place(k);
  Pack* const quarter = pairs.g;  // |e|^2 / 4
  count_up<fixed, 0, neighbours - 1>(0, count - 1, [&](auto j_) PHYMUL_INLINED {
    const int j = number(j_), first = pairs_of(count, j);
    constexpr int cj = number_of<decltype(j_)>;
    const Pack3 across = cross(F, place[j]);
    count_up<fixed, cj + 1, neighbours>(j + 1, count, [&](auto l_) PHYMUL_INLINED {
      const int p = first + number(l_);
      volume[p] = dot(across, place[number(l_)]);
      quarter[p] = 0.25f * pairs.g[p] + 0.5f * pairs.eta[p];
      S[p] = T[p] = Pack{};
    });
  });
  const float* row = n.triples;
  count_up<fixed, 0, neighbours - 2>(0, count - 2, [&](auto j_) PHYMUL_INLINED {
    const int j = number(j_), of_j = pairs_of(count, j);
    constexpr int cj = number_of<decltype(j_)>;
    count_up<fixed, cj + 1, neighbours - 1>(j + 1, count - 1, [&](auto k_) PHYMUL_INLINED {
      const int k = number(k_), of_k = pairs_of(count, k);
      constexpr int ck = number_of<decltype(k_)>;
      const Pack q1 = quarter[of_j + k], volume1 = volume[of_j + k];
      Pack S1{}, T1{};
      count_up<fixed, ck + 1, neighbours>(k + 1, count, [&](auto l_) PHYMUL_INLINED {
        const int jl = of_j + number(l_), kl = of_k + number(l_);
        const Pack rho = *changes++ + 1.0f;
        const Pack s = load(row) * rho;
        const Pack along = (volume1 + volume[kl]) - volume[jl];  // w.F
        const Pack t = (s * (rho * rho)) * (load(row + lanes) * along);
        const Pack q2 = quarter[jl], q3 = quarter[kl];
        const Pack difference = q1 - q2;
        S1 += s;
        S[jl] -= s;
        S[kl] += s;
        T1 += t * (q3 - difference);
        T[jl] += t * (q3 + difference);
        T[kl] += t * ((q1 + q2) - q3);
        row += 2 * lanes;
      });
      S[of_j + k] += S1;
      T[of_j + k] += T1;
    });
  });
  count_up<fixed, 0, neighbours>(0, count, [&](auto k_) PHYMUL_INLINED {
    const int k = number(k_), of_k = pairs_of(count, k);
    constexpr int ck = number_of<decltype(k_)>;
    Pack3 f = -(n.alpha(k) * F), across{};
    Pack tension{};
    count_up<fixed, 0, ck>(0, k, [&](auto l_) PHYMUL_INLINED {
      const int l = number(l_), p = pairs_of(count, l) + k;
      tension += T[p];
      f -= T[p] * place[l];
      across += S[p] * place[l];
    });
    count_up<fixed, ck + 1, neighbours>(k + 1, count, [&](auto l_) PHYMUL_INLINED {
      const int l = number(l_), p = of_k + l;
      tension += T[p];
      f -= T[p] * place[l];
      across -= S[p] * place[l];
    });
    scatter_add(force, n.offsets + k * lanes, f + tension * place[k] + cross(across, F));
  });
}

}  // namespace phymul::cpu::PHYMUL_ISA
