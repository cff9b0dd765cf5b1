// SPDX-License-Identifier: MIT
//
// TopologyTextures: the constants of an elastic body, in the tables that every backend reads. Once built they change by
// edits alone. Notation: topology.h.
//
// The first four are those of the 2007 thesis:
//   index       per particle: Nc, X, Bc, X' = number of neighbours, row of the first in `neighbours`,
//               number of bases, row of the first in `bases`
//   neighbours  per row: particle number                                (rows X ... X + Nc - 1 belong to one particle)
//   bases       per row: particles a, b, c and the height beta          (rows X' ... X' + Bc - 1)
//   alpha       per row of `neighbours`: alpha_ij
// The last three have no rows, and Nc is 0, where no particle has a base: in bodies with a material and of springs.
// Other tables are empty unless the options need them. Integers are stored as integers: a float holds them only to
// 2^24.
#pragma once

#include <phymul/body_cut.h>
#include <phymul/topology.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace phymul {

inline constexpr Index none = -1;

/// Rectangle of texels that holds a table on a device: row-major, near-square, width a power of two.
struct TextureShape {
  int width = 0;
  int height = 0;

  std::int64_t texels() const { return std::int64_t{width} * height; }
  std::array<int, 2> texel(Index row) const { return {row % width, row / width}; }
  bool operator==(const TextureShape&) const = default;
};

/// Smallest such rectangle for `rows` rows with sides up to `limit`; at least 1 x 1. Throws Error if none is large
/// enough. `table`: name for the message.
TextureShape fit_texture(std::int64_t rows, int limit, const char* table);

struct IndexTexel {
  Index neighbour_count = 0;  ///< Nc
  Index first_neighbour = 0;  ///< X
  Index base_count = 0;       ///< Bc
  Index first_base = 0;       ///< X'
  bool operator==(const IndexTexel&) const = default;
};

struct BaseTexel {
  std::array<Index, 3> vertex{none, none, none};  ///< a, b, c; c is none in 2-D
  double beta = 0.0;                              ///< m
  bool operator==(const BaseTexel&) const = default;
};

struct SpringTexel {
  std::array<Index, 2> end{none, none};
  double rest_length = 0.0;  ///< m
  double stiffness = 0.0;    ///< N/m
};

/// Volume energy of a tetrahedron (triangle in 2-D, d none, volumes per unit thickness).
struct VolumeTexel {
  std::array<Index, 4> vertex{none, none, none, none};
  double inverse_rest_volume = 0.0;  ///< 1/m^3: J = volume * this
  double stiffness = 0.0;            ///< J: kappa times the rest volume this term stands for
};

/// A triangle of a wall (Law::walls) with its patch. Derivatives are by coordinates along `tangent`. With displacements
/// u_k of the vertices:
///   x_,a = tangent_a + sum gradient_ka u_k,   x_,ab = second_ab + sum hessian_kab u_k
/// ab = 11, 22 and twice 12. Where a vertex is none its weights are 0.
struct WallTexel {
  /// The triangle, then the vertices across the sides (1, 2), (2, 0), (0, 1).
  std::array<Index, 6> vertex{none, none, none, none, none, none};
  std::array<Vec3, 2> tangent{Vec3::Zero(), Vec3::Zero()};               ///< at rest, orthonormal
  std::array<Vec3, 3> second{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< at rest, 1/m
  std::array<std::array<double, 2>, 6> gradient{};                       ///< 1/m
  std::array<std::array<double, 3>, 6> hessian{};                        ///< 1/m^2
  std::array<double, 6> bending{};  ///< A t^3/12 C, N m^3: of 11 11, 22 22, 12 12, 22 12, 11 12, 11 22
  double shear = 0.0;               ///< A t mu, J
  double compliance = 0.0;          ///< 2 mu / (3 K)
};

inline constexpr std::size_t most_energy_constants = 6;

/// Constants of TopologyOptions::strain_energy, in the order in which StrainEnergy names them, then zeros.
using EnergyConstants = std::array<double, most_energy_constants>;

/// A domain of Law::particle_averaged: the neighbourhood of a particle or, where materials meet, its part in one.
/// Domains that lie alike, as in a lattice, have the same rows of links.
struct DomainTexel {
  Index particle = none;
  Index material = 0;  ///< row of Model::materials
  Index first_link = 0, link_count = 0;
  Index first_surface_link = 0, surface_link_count = 0;
  Index energy = 0;               ///< row of TopologyTextures::energies; domains that share one are of one material
  double inverse_volume = 0.0;    ///< 1/V_d, 1/m^3
  double spread_stiffness = 0.0;  ///< s mu, Pa: the stabiliser times the shear modulus
};

/// The link of domain d, one of whose rows this is, to domain e = d + offset. From e to d the area has the opposite
/// sign and the stiffness is the same. In a body of points (Law::particle_averaged) sums of w X_pq and s mu w replace
/// the integrals.
struct LinkTexel {
  Index offset = 0;
  Vec3 area = Vec3::Zero();  ///< half the integral of N_d grad N_e - N_e grad N_d, m^2
  double stiffness = 0.0;    ///< -integral of s mu grad N_d . grad N_e, N/m
  bool operator==(const LinkTexel&) const = default;
};

/// The symmetric part of the integral of N_d grad N_e, if it is not zero: on the surface of the body or of a material,
/// also for e = d. The same from both sides. In a body of points it is in general not zero inside either.
struct SurfaceLinkTexel {
  Index offset = 0;
  Vec3 area = Vec3::Zero();  ///< half the integral over the surface of N_d N_e times the outward normal, m^2
  bool operator==(const SurfaceLinkTexel&) const = default;
};

/// How the material of a domain dissipates (Material). Small-strain tensor: 2 mu E + lambda tr(E) I.
struct DissipationTexel {
  double mu = 0.0, lambda = 0.0;     ///< Pa, Lame's constants of Material::young and poisson
  double retardation_time = 0.0;     ///< s
  double relaxation_strength = 0.0;  ///< 1
  double relaxation_time = 0.0;      ///< s, > 0 where relaxation_strength is
};

/// Hashes (FNV-1a, 64 bits) of the parts of a model that the tables were built from. With them a solver finds what has
/// changed since.
struct ModelFingerprint {
  std::uint64_t neighbours = 0, cells = 0;
  std::uint64_t materials = 0;  ///< row and constants of each cell, without density; of a body of points with density
  std::uint64_t stiffness = 0;  ///< of particles, if there are no materials
  bool operator==(const ModelFingerprint&) const = default;
};

/// Whoever edits tables that solvers use (BodyEdit, src/topology/body_edit.h) calls Solver::body_changed() then.
struct TopologyTextures {
  TopologyOptions options;  ///< as built, law and stabiliser included
  int dimension = 3;
  /// Of the model that the tables were built from. Empty in tables that build_topology() did not make; solvers then
  /// compare only rest positions and masses.
  std::optional<ModelFingerprint> model;
  /// Warnings of build_topology about meshes for which the law is inaccurate, one sentence each.
  std::vector<std::string> notes;

  Index particle_count = 0;
  Index neighbour_count = 0;  ///< rows of neighbours and alpha; 0 if there are no bases
  Index base_count = 0;       ///< rows of bases, lambda, weight

  std::vector<IndexTexel> index;
  std::vector<Index> neighbours;
  std::vector<BaseTexel> bases;
  std::vector<double> alpha;

  // Per particle.
  VecList rest;                   ///< m
  std::vector<double> mass;       ///< kg
  std::vector<double> stiffness;  ///< k_i, N/m

  // Per base.
  std::vector<std::array<double, 3>> lambda;
  std::vector<double> weight;  ///< w_t

  // Further terms of the energy, empty unless the options need them.
  std::vector<SpringTexel> springs;
  std::vector<VolumeTexel> volumes;
  std::vector<WallTexel> walls;  ///< of triangles with a thickness, by any law with a material

  // Law::particle_averaged: domains in order of their particles.
  std::vector<DomainTexel> domains;
  std::vector<EnergyConstants> energies;
  std::vector<Index> first_domain;  ///< [N + 1]
  std::vector<LinkTexel> links;     ///< of a domain in order of their offsets, as surface_links
  std::vector<SurfaceLinkTexel> surface_links;
  std::vector<DissipationTexel> dissipation;  ///< [domains]; empty where no material dissipates

  const EnergyConstants& energy_of(Index domain) const { return energies[domains[domain].energy]; }
  std::span<const LinkTexel> links_of(Index domain) const {
    return std::span(links).subspan(domains[domain].first_link, domains[domain].link_count);
  }
  std::span<const SurfaceLinkTexel> surface_links_of(Index domain) const {
    return std::span(surface_links).subspan(domains[domain].first_surface_link, domains[domain].surface_link_count);
  }

  // Edits since build_topology() (Simulation::remove_cells).
  std::vector<Index> removed;  ///< rows of Model::cells, ascending
  /// Domains whose rows, or whose particles' masses, changed: in order of the changes, so that a domain may recur.
  /// Numbers of particles and domains stay. A domain without a cell keeps its volume and has no links.
  std::vector<Index> edited;
  std::size_t edits = 0;                     ///< number of changes, those of `edited` and of walls and their masses
  BodyCuts cuts;                             ///< those made and not undone, in order (Simulation::cut)
  std::vector<std::array<Index, 2>> copied;  ///< of all cuts made: a copy, and the particle that it copies
  /// Of all edits, in order: a particle whose mass changed in exchange with copies at its place. `family`: the particle
  /// that all of these are copies of. `before`: kg.
  struct Exchanged {
    Index particle = 0, family = 0;
    double before = 0.0;
  };
  std::vector<Exchanged> exchanged;
  double stiffened = 1.0;              ///< a bound, >= 1, of the factor by which that raised the largest eigenvalue
  std::optional<std::uint64_t> built;  ///< fingerprint() before the first edit

  // Transposed lists, because a shader can gather but not scatter. An entry is (row of the term) * corners + corner.
  RaggedList neighbour_of;             ///< per particle j: rows r of `neighbours` with neighbours[r] = j (corners = 1)
  RaggedList base_of;                  ///< per particle: base row * 3 + corner (2-D too)
  RaggedList spring_of;                ///< spring row * 2 + end
  RaggedList volume_of;                ///< volume row * 4 + corner
  std::vector<Index> neighbour_owner;  ///< [neighbour_count] particle whose neighbour row it is
  std::vector<Index> base_owner;       ///< [base_count] particle whose base it is
};

/// Hash (FNV-1a, 64 bits) of the constants and indices of the tables. It depends on material, rest shape, masses,
/// options and order of the particles; of an edited body on what it had been, on the cuts and on the cells that are
/// removed now.
/// Files contain it; it is the same on every system.
std::uint64_t fingerprint(const TopologyTextures& topology);
/// What it is while these cells (TopologyTextures::removed) are the removed ones and these are the cuts.
std::uint64_t fingerprint(const TopologyTextures& topology, std::span<const Index> removed, const BodyCuts& cuts);

}  // namespace phymul
