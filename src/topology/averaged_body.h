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
  std::vector<Index> kind;                ///< [D] domains that lie alike (find_kinds()) are of one kind
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

/// Fills the tables of the law. options.stabiliser, where it has none, is calibrated (stabiliser.cpp) and written back.
void add_averaged_terms(const Model& model, TopologyTextures& topology);

/// Most vertices of a solid cell.
inline constexpr Index most_vertices = 8;

/// Fills Domains::kind and first_of_kind: constants of domains that lie alike, as most do in a lattice, are computed
/// and stored once. Two domains are of one kind if they are of one material, in cells of the same types, whose domains
/// differ from them by the same numbers and whose particles lie the same from theirs, up to the rounding of
/// coordinates. Parts of a body that no cell joins have kinds of their own, so that each is as it is alone. `cells`:
/// per domain the entries (row of a cell) * most_vertices + vertex that it is there.
void find_kinds(const Model& model, const RaggedList& cells, Domains& domains);

/// What rounding leaves of an area that is zero by symmetry, over the largest one of its domain.
inline constexpr double rounding_of_area = 1e-11;

/// Fills TopologyTextures::links and surface_links, and the rows that the domains have there. Domains that lie alike
/// and whose links are equal share their rows.
void add_links(const Domains& domains, const PairStiffness& stiffness, TopologyTextures& topology);

/// Constants of a body of points, particles with neighbours and one material, but no cells: one domain for each, of the
/// volume that its mass and the material's density give it.
struct PointDomains {
  Domains domains;          ///< pairs in both directions; the area of a pair is not antisymmetric; each is a kind
  PairStiffness stiffness;  ///< at s mu = 1, m
  double stabiliser = 0.0;  ///< by pure bending of the body, as in CalibratedStabiliser; may be below 0
};

/// Throws Error unless the model has one material and each particle neighbours that span its dimension.
PointDomains point_domains(const Model& model);

/// The stabiliser s, calibrated on the body itself, as pure bending must cost what it should: for the cells of one type
/// in one part of a body.
struct CalibratedStabiliser {
  Index part = 0;
  CellType type = CellType::tetrahedron;
  double value = 0.0;   ///< the mean over the six bendings (2-D: two); too little for a fine enough mesh may be below 0
  double lowest = 0.0;  ///< of the bendings
  double highest = 0.0;
};

struct CalibratedStabilisers {
  std::vector<CalibratedStabiliser> all;
  std::vector<Index> part;  ///< [N] of each particle: what no pair of domains joins are two parts
  Index parts = 0;

  /// Per row of Model::cells, no value below least_stabiliser or, where a part has no particle inside,
  /// least_stabiliser_of_layers; 0 for cells that are not solid.
  std::vector<double> of_cells(const Model& model, const Domains& domains) const;
};

/// The bending u_a = x_a x_b, u_b = -(x_a^2 + nu (x_b^2 - x_c^2)) / 2, u_c = -nu x_b x_c about the centroid of a part,
/// along its own axes (body_frames.h), has the energy E/2 integral of x_b^2 in linear elasticity. Put on the particles
/// it costs the energy of the means, which is too little, and s times that of the spread: s makes up the difference. In
/// 2-D, where strain is plane, nu and E are nu / (1 - nu) and E / (1 - nu^2), and c is none. Cells count with E = 1, so
/// that soft ones are heard; one value for each part and type of cell.
CalibratedStabilisers calibrated_stabilisers(const Model& model, const Domains& domains);

}  // namespace phymul
