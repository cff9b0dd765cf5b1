// SPDX-License-Identifier: MIT
//
// Constants of Law::particle_averaged (topology.h) from the cells of a model.
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul {

/// Domains in order of particles, those of one particle in order of materials.
struct Domains {
  std::vector<Index> particle, material;  ///< [D]
  std::vector<double> volume;             ///< [D] integral of N_d, m^3
  RaggedList pairs;    ///< per domain d: the domains e that share a cell with it, d itself too, in increasing order
  VecList area;        ///< per entry of pairs: C_de = integral of N_d grad N_e, m^2
  RaggedList of_cell;  ///< per row of Model::cells: the domains of its vertices; empty for cells that are not solid

  TaskRunner* host = nullptr;  ///< whose threads compute with them; null: their own

  Index count() const { return static_cast<Index>(particle.size()); }
  /// Entry of the pair (d, e); precondition: there is one.
  Index pair(Index d, Index e) const;
};

/// Throws Error where a solid cell has no material, or is folded.
Domains domains_of(const Model& model, TaskRunner* host = nullptr);

/// Fills the tables of the law. options.stabiliser, where it has none, is calibrated (stabiliser.h) and written back.
void add_averaged_terms(const Model& model, TopologyTextures& topology);

}  // namespace phymul
