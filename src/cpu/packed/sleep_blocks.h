// SPDX-License-Identifier: MIT
//
// A body of Law::particle_averaged divided into blocks of neighbouring particles, and what their motion depends on.
#pragma once

#include <phymul/topology_textures.h>

#include <cstdint>
#include <span>
#include <vector>

#include "packed_body.h"

namespace phymul::cpu {

/// Block b has the places b * size ... (b + 1) * size - 1. The division depends on nothing but the order of places,
/// so never on the number of threads.
struct SleepBlocks {
  /// Places in a block, a multiple of all lanes. Fewer cost more of a step for their own bookkeeping, more keep more
  /// particles awake around those that move.
  static constexpr int size = 128;

  int count = 0;
  std::vector<std::int32_t> first_reached;  ///< [count + 1] of `reached`
  std::vector<std::int32_t> reached;        ///< per block: those whose next state depends on its displacements
  std::vector<std::int32_t> first_further;  ///< [count + 1] of PackedAverages::further

  std::span<const std::int32_t> reach(int block) const {
    return {reached.data() + first_reached[block], reached.data() + first_reached[block + 1]};
  }
  static std::size_t of_quad(std::size_t quad) { return quad / size; }  // quad_of() stays within a slice
};

/// `body`: of the same tables.
SleepBlocks make_sleep_blocks(const TopologyTextures& topology, const PackedBody& body);

}  // namespace phymul::cpu
