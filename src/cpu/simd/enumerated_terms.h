// SPDX-License-Identifier: MIT
//
// Attractors of particles that have nearly all triples j < k < l of their neighbours for bases: all lanes of a slice
// have their triples in one order, so that each neighbour is gathered once and a base costs two constants.
#pragma once

#include "base_terms.h"
#include "neighbourhood.h"
#include "triple_lengths.h"

namespace phymul::cpu::PHYMUL_ISA {

// Enumerated triples by their normals, as base_terms.h has them: right for triangles of any shape, however far they are
// from rest. triple_lengths.h is the fast way.

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

inline constexpr int most_unrolled = 6;
/// So many of the constants of particles with that many neighbours, or more, for each of those.
inline constexpr int columns_a_neighbour = simd::neighbour_columns + 3 + 7;

/// Works on one slice, whose neighbourhood is gathered.
template <bool averaged, int neighbours>
PHYMUL_APART void enumerated_slice(const simd::Job& job, int slice, const Neighbourhood& n) {
  Pack changes[neighbours > 0 ? 64 : simd::most_enumerated_triples];
  PairLengths<neighbours> pairs;
  Pack3 pull;
  const bool near = !n.thin && pull_by_lengths<averaged, neighbours>(n, pairs, changes, pull);
  if (!near) pull = pull_by_normals<averaged>(n, changes);
  const Pack3 F = load(job.stiffness + slice * lanes) * pull;
  if constexpr (averaged) {
    if (near) {
      give_back_by_lengths<neighbours>(n, pairs, changes, F, job.force);
    } else {
      give_back_by_normals(n, changes, F, job.force);
    }
    add_row(job.force + 16 * lanes * slice, F);
  } else {
    store_row(job.pull + 16 * lanes * slice, F);
  }
}

template <bool averaged>
void enumerated_slices(const simd::Job& job) {
  Neighbourhood n;
  const simd::Enumerated& rows = job.enumerated;
  n.offsets = rows.offsets;
  for (int slice = 0; slice < rows.count; ++slice) {
    n.count = rows.neighbours[slice] & simd::neighbour_count;
    n.thin = (rows.neighbours[slice] & simd::thin_triples) != 0;
    n.fresh = job.far && (rows.neighbours[slice] & simd::known_constants) == 0;
    n.edges = rows.rows + static_cast<std::int64_t>(rows.first[slice]) * lanes;
    n.pairs = n.row(n.count);
    n.triples = n.pairs + n.count * (n.count - 1) / 2 * lanes;
    const Pack3 ui = gather_row(job.u + 16 * lanes * slice);
    const float* ahead = n.edges;
    for (int k = 0; k < n.count; ++k) {
      // The kernels for few neighbours have no loop of triples to ask for the next ones in.
      if (n.fresh && n.count <= most_unrolled) {
        for (int column = 0; column < columns_a_neighbour; ++column, ahead += lanes) prefetch_rows<1>(ahead);
      }
      n.half[k] = all(0.5f) * (gather(job.u, n.offsets + k * lanes) - ui);
      n.middle[k] = n.E(k) + n.half[k];
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
    n.offsets += n.count * lanes;
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
