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
  std::vector<Index> kind;                ///< [D] domains that lie alike (alike_domains.h) are of one kind
  RaggedList of_cell;  ///< per row of Model::cells: the domains of its vertices; empty for cells that are not solid

  // Per kind, of any domain d that is of it.
  std::vector<Index> first_of_kind;
  std::vector<double> volume;  ///< integral of N_d, m^3
  RaggedList pairs;            ///< e - d of the domains e that share a cell with d, also 0, in increasing order
  VecList area;                ///< per entry of pairs: C_de = integral of N_d grad N_e, m^2

  TaskRunner* host = nullptr;  ///< whose threads compute with them; null: their own

  Index count() const { return static_cast<Index>(particle.size()); }
  bool is_first_of_kind(Index d) const { return first_of_kind[kind[d]] == d; }
  Index pair_count(Index d) const { return pairs.size(kind[d]); }
  Index first_pair(Index d) const { return pairs.offset[kind[d]]; }  ///< entry of pairs
  /// Which of the pairs of d is the one with e. Precondition: there is one.
  Index place(Index d, Index e) const;
  /// Calls visit(e, entry of pairs) for each pair of d.
  template <class Visit>
  void for_each_pair(Index d, const Visit& visit) const {
    for (Index r = pairs.offset[kind[d]]; r < pairs.offset[kind[d] + 1]; ++r) visit(d + pairs.entry[r], r);
  }
};

/// -integral of s mu grad N_d . grad N_e for the pairs with e < d, N/m; of the others, where it is the same, 0.
struct PairStiffness {
  std::vector<Index> first;  ///< [D] row in `value` of the first pair of d; domains that are equally stiff share theirs
  std::vector<double> value;  ///< per pair
};

/// Throws Error where a solid cell has no material, or is folded.
Domains domains_of(const Model& model, TaskRunner* host = nullptr);

/// Fills the tables of the law. options.stabiliser, where it has none, is calibrated (stabiliser.h) and written back.
void add_averaged_terms(const Model& model, TopologyTextures& topology);

}  // namespace phymul
