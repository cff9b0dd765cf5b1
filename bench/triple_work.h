// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

namespace phymul::bench {

/// Multiplications and multiply-adds of the kernel of enumerated triples (src/cpu/simd/triple_lengths.h, the pull) for
/// all particles of a body: 11 a triple, 19 a pair of neighbours, 18 a neighbour. What the multiplying units see.
inline double triple_multiplications(const TopologyTextures& tables) {
  double sum = 0.0;
  for (const IndexTexel& particle : tables.index) {
    const double n = particle.base_count > 0 ? particle.neighbour_count : 0;
    sum += 11.0 * n * (n - 1.0) * (n - 2.0) / 6.0 + 19.0 * n * (n - 1.0) / 2.0 + 18.0 * n;
  }
  return sum;
}

}  // namespace phymul::bench
