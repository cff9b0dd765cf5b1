// SPDX-License-Identifier: MIT
//
// Enumerated triples by their normals, as base_terms.h has them: right for triangles of any shape, however far they are
// from rest. triple_lengths.h is the fast way.
#pragma once

#include "base_terms.h"
#include "neighbourhood.h"

namespace phymul::cpu::PHYMUL_ISA {

/// P* - x; keeps 1 / sqrt(a) - 1 of each triple where asked for.
template <bool keep>
PHYMUL_APART Pack3 pull_by_normals(const Neighbourhood& n, Pack* changes) {
  Pack3 sum{};
  const float* row = n.triples;
  Pack3 E2[simd::most_enumerated], d2[simd::most_enumerated], e2[simd::most_enumerated];
  Pack length2[simd::most_enumerated];
  for (int j = 0; j < n.count - 2; ++j) {
    for (int l = j + 1; l < n.count; ++l) {
      const Pack3 h = n.half[l] - n.half[j], m = n.middle[l] - n.middle[j];
      E2[l] = m - h;
      d2[l] = h + h;
      e2[l] = m + h;
      length2[l] = dot(e2[l], e2[l]);
    }
    for (int k = j + 1; k < n.count - 1; ++k) {
      const Pack3 E1 = E2[k], d1 = d2[k], e1 = e2[k];
      const Pack bound = collapsed * length2[k];
      for (int l = k + 1; l < n.count; ++l, row += 2 * lanes) {
        const Pack rest = 0.5f * load(row + lanes);
        const Pack3 w = cross(e1, e2[l]), dw = cross(d1, e2[l]) + cross(E1, d2[l]);
        const Pack q = dot(w, w), y = dot(dw, w + (w - dw)) * rest;
        // Where there is no base, `rest` is 0.
        const Pack c = select(rest > 0.0f, inverse_root_change(q * rest, y), Pack{});
        const Pack change = select(q > bound * length2[l], c, all(-1.0f));
        sum += load(row) * (dw + change * w);
        if constexpr (keep) *changes++ = change;
      }
    }
  }
  return along_neighbours(n) + sum;
}

/// What F costs the neighbours, as base_terms.h's give_back over all triples. The lambda of all bases together are
/// alpha.
PHYMUL_APART inline void give_back_by_normals(const Neighbourhood& n, const Pack* changes, Pack3 F, char* force) {
  Pack3 f[simd::most_enumerated], e2[simd::most_enumerated];
  for (int k = 0; k < n.count; ++k) f[k] = -(n.alpha(k) * F);
  const float* row = n.triples;
  for (int j = 0; j < n.count - 2; ++j) {
    for (int l = j + 1; l < n.count; ++l) e2[l] = n.place(l) - n.place(j);
    Pack3 fj{};
    for (int k = j + 1; k < n.count - 1; ++k) {
      const Pack3 e1 = e2[k];
      Pack3 fk{}, all_G{};
      for (int l = k + 1; l < n.count; ++l, row += 2 * lanes) {
        const Pack rho = *changes++ + 1.0f;
        const Pack3 w = cross(e1, e2[l]);
        const Pack3 G = (load(row) * rho) * (F - (0.5f * load(row + lanes) * rho * rho * dot(w, F)) * w);
        fk -= cross(e2[l], G);
        all_G += G;
        f[l] -= cross(G, e1);
      }
      f[k] += fk;
      fj += cross(all_G, e1) - fk;
    }
    f[j] += fj;
  }
  for (int k = 0; k < n.count; ++k) scatter_add(force, n.offsets + k * lanes, f[k]);
}

}  // namespace phymul::cpu::PHYMUL_ISA
