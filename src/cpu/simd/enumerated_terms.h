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

/// P* - x; keeps 1 / sqrt(a) - 1 of each triple where asked for.
template <bool keep>
PHYMUL_INLINE Pack3 enumerated_pull(const Neighbourhood& n, Pack* changes) {
  Pack3 sum{}, along{};
  for (int k = 0; k < n.count; ++k) along += n.alpha(k) * n.d[k];
  const float* row = n.triples;
  Pack3 d2[simd::most_enumerated], e2[simd::most_enumerated];
  Pack length2[simd::most_enumerated];
  for (int j = 0; j + 2 < n.count; ++j) {
    const Pack3 Ej = n.E(j), dj = n.d[j];
    for (int l = j + 1; l < n.count; ++l) {
      d2[l] = n.d[l] - dj;
      e2[l] = (n.E(l) - Ej) + d2[l];
      length2[l] = dot(e2[l], e2[l]);
    }
    for (int k = j + 1; k + 1 < n.count; ++k) {
      const Pack3 E1 = n.E(k) - Ej, d1 = d2[k], e1 = e2[k];
      const Pack bound = collapsed * length2[k];
      for (int l = k + 1; l < n.count; ++l, row += 2 * lanes) {
        const Pack rest = load(row + lanes);
        const Pack3 w = cross(e1, e2[l]), dw = cross(d1, e2[l]) + cross(E1, d2[l]);
        const Pack q = dot(w, w), y = dot(dw, all(2.0f) * w - dw) * rest;
        const Pack c = select(q > bound * length2[l], inverse_root_change(q * rest, y), all(-1.0f));
        sum += load(row) * (dw + c * w);
        if constexpr (keep) *changes++ = c;
      }
    }
  }
  return along + sum;
}

/// What F costs the neighbours, as base_terms.h's give_back over all triples. The lambda of all bases together are
/// alpha.
PHYMUL_INLINE void enumerated_give_back(const Neighbourhood& n, const Pack* changes, Pack3 F, char* force) {
  Pack3 f[simd::most_enumerated], e2[simd::most_enumerated];
  for (int k = 0; k < n.count; ++k) f[k] = -(n.alpha(k) * F);
  const float* row = n.triples;
  for (int j = 0; j + 2 < n.count; ++j) {
    const Pack3 ej = n.e[j];
    for (int l = j + 1; l < n.count; ++l) e2[l] = n.e[l] - ej;
    Pack3 fj{};
    for (int k = j + 1; k + 1 < n.count; ++k) {
      const Pack3 e1 = e2[k];
      Pack3 fk{}, all_G{};
      for (int l = k + 1; l < n.count; ++l, row += 2 * lanes) {
        const Pack rho = *changes++ + 1.0f;
        const Pack3 w = cross(e1, e2[l]);
        const Pack3 G = (load(row) * rho) * (F - (load(row + lanes) * rho * rho * dot(w, F)) * w);
        fk -= cross(e2[l], G);
        all_G += G;
        f[l] -= cross(G, e1);
      }
      f[k] += fk;
      fj += cross(all_G, e1) - fk;
    }
    f[j] += fj;
  }
  for (int k = 0; k < n.count; ++k) {
    std::int32_t offset[lanes];
    __builtin_memcpy(offset, n.edges + 5 * k * lanes, sizeof offset);
    scatter_add(force, offset, f[k]);
  }
}

template <bool averaged>
void enumerated_slices(const simd::Job& job) {
  Neighbourhood n;
  Pack changes[simd::most_enumerated_triples];
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
    const Pack3 F = load(job.stiffness + slice * lanes) * enumerated_pull<averaged>(n, changes);
    if constexpr (averaged) {
      enumerated_give_back(n, changes, F, job.force);
      add_row(job.force + 16 * lanes * slice, F);
    } else {
      store_row(job.pull + 16 * lanes * slice, F);
    }
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
