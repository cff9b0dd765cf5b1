// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

namespace phymul::bench {

/// What attractors over enumerated triples cost: for the pull by lengths of src/cpu/simd/triple_lengths.h and the
/// neighbourhood it starts from, counted there by hand.
struct TripleWork {
  double multiplications = 0.0;  ///< and multiply-adds: what the multiplying units see
  double operations = 0.0;       ///< of floating point; a multiply-add is two, a rough root, least or largest one
};

/// Of all particles of a body, a step. Of a triple: 12 multiplications, 9 of them multiply-adds, and 10 others.
inline TripleWork triple_work(const TopologyTextures& tables) {
  TripleWork work;
  for (const IndexTexel& particle : tables.index) {
    const double n = particle.base_count > 0 ? particle.neighbour_count : 0;
    const double pairs = n * (n - 1.0) / 2.0, triples = pairs * (n - 2.0) / 3.0;
    work.multiplications += 12.0 * triples + 16.0 * pairs + 18.0 * n;
    work.operations += 31.0 * triples + 40.0 * pairs + 43.0 * n;
  }
  return work;
}

}  // namespace phymul::bench
