// SPDX-License-Identifier: MIT
//
// Constants of Law::particle_averaged (topology.h) from the cells of a model.
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

namespace phymul {

/// What links two domains of one material, d and e, before the stabiliser has its value.
struct DomainPair {
  Index domain;  ///< e
  Vec3 area;     ///< C_de = integral of N_d grad N_e, m^2
};

/// Domains in order of particles, those of one particle in order of materials; rows of pairs in order of e, with d
/// itself.
struct Domains {
  std::vector<Index> particle, material;  ///< [D]
  std::vector<double> volume;             ///< [D] integral of N_d, m^3
  std::vector<Index> first_pair{0};       ///< [D + 1]
  std::vector<DomainPair> pairs;
  RaggedList of_cell;  ///< per row of Model::cells: the domains of its vertices; empty for cells that are not solid

  Index count() const { return static_cast<Index>(particle.size()); }
  /// Row of the pair (d, e); precondition: there is one.
  Index pair(Index d, Index e) const;
};

/// Throws Error where a solid cell has no material, or is folded.
Domains domains_of(const Model& model);

/// Fills the tables of the law. options.stabiliser, where it has none, is calibrated (stabiliser.h) and written back.
void add_averaged_terms(const Model& model, TopologyTextures& topology);

}  // namespace phymul
