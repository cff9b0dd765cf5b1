// SPDX-License-Identifier: MIT
//
// A body with its particles renumbered, for locality (locality_order.h).
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul::cpu {

/// The same body with particle order[i] as particle i. Rows of bases follow their owners; springs, volumes and cells
/// are sorted by their first particle; neighbour rows keep their order within a particle. Padding is dropped.
TopologyTextures renumbered(const TopologyTextures& topology, const std::vector<Index>& order);

}  // namespace phymul::cpu
