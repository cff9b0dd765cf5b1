// SPDX-License-Identifier: MIT
//
// Attractors of particles that have nearly all triples j < k < l of their neighbours for bases: all lanes of a slice
// have their triples in one order, so that each neighbour is gathered once and a base costs two constants.
#pragma once

#include "triple_lengths.h"
#include "triple_normals.h"

namespace phymul::cpu::PHYMUL_ISA {

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
