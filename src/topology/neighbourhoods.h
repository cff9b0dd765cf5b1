// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul {

/// A particle's bases as triples j < k < l of its neighbours.
struct Triples {
  std::vector<Index> neighbour;  ///< in the order of its rows
  std::vector<double> alpha;     ///< of each
  std::vector<Index> base;       ///< row of each triple in that order, or none
};
/// Place of j < k < l among the triples of n neighbours.
Index triple_row(Index n, Index j, Index k, Index l);
Triples triples_of(const TopologyTextures& t, Index i);

/// True where nearly all triples of neighbours are bases, none has more than `most` neighbours and no base has other
/// vertices: the body's attractors can be enumerated.
bool is_enumerable(const TopologyTextures& topology, Index most);

}  // namespace phymul
