// SPDX-License-Identifier: MIT
//
// Some materials of a body of Law::particle_averaged as tables of their own. Exact, because links join domains of one
// material.
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul {

/// The domains of some materials, and the particles that have one.
struct PartOfBody {
  TopologyTextures tables;
  std::vector<Index> particle;  ///< of the whole body, in ascending order
};
/// `chosen`: by row of Model::materials; further rows are not chosen. Domains keep their order.
PartOfBody part_of(const TopologyTextures& topology, const std::vector<bool>& chosen);

/// [rows of Model::materials] whether it has domains.
std::vector<bool> materials_of(const TopologyTextures& topology);

}  // namespace phymul
