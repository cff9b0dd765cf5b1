// SPDX-License-Identifier: MIT
//
// How a Model becomes the constant tables of a simulation (topology_textures.h): the elastic law and its options.
//
// Notation, used by every kernel:
//   x_i, X_i    position of particle i now and at rest, m
//   Nc_i, Bc_i  number of neighbours, number of bases of particle i
//   k_i         shape stiffness, N/m: Model::stiffness, or computed from the material
//   t = (a,b,c) a base of i: three particles (two in 2-D) around it
//   n_t         unit normal of t: (x_b - x_a) x (x_c - x_a), normalised (2-D: left normal of x_b - x_a)
//   lambda_t    barycentric coordinates in t of the projection of X_i on its plane, rest shape, sum 1
//   beta_t      signed height of X_i over t, m, rest shape
//   A_t, A_t0   area of t now and at rest
//   w_t         weight of t among the bases of i, sum 1; 1 / Bc_i unless the model has a material
//   alpha_ij    sum over t of w_t lambda_t at vertex j, rest shape, sum over j = 1
//   P*_t        position that base t predicts for i: sum_v lambda_tv x_v + beta_t n_t
//   P*_i        attractor, their mean: sum_t w_t P*_t = sum_j alpha_ij x_j + sum_t w_t beta_t n_t
// "The thesis" is the one of 2007 that introduced this model (docs/README.md).
#pragma once

#include <phymul/model.h>

#include <cstdint>
#include <optional>

namespace phymul {

enum class Law {
  springs,
  shape_memory,
  /// One deformation gradient per particle, the mean over its neighbourhood. Needs a material. With shape functions N_i
  /// of the cells and displacements u:
  ///   V_i = integral of N_i,  C_ij = integral of N_i grad N_j,  F_i = I + 1/V_i sum_j (u_j - u_i) C_ij^T
  ///   E = sum_i V_i psi(F_i) + s/2 (integral of mu |F|^2 - sum_i mu_i V_i |F_i|^2)
  /// psi is the energy of Calibration at F_i, averaged over seven directions instead of all, with VolumeLaw. The second
  /// term, of weight s (TopologyOptions::stabiliser), is what the means leave out. A particle where materials meet has
  /// a mean and an energy for each. In 2-D strain is plane.
  /// A body of points, without cells that fill space, has one material and V_i = mass / density. For edges e = pq
  /// between neighbours or from i, with weights w > 0 such that sum_e w_e X_pq X_pq^T = V_i I,
  ///   F_i = I + 1/V_i sum_e w_e (u_q - u_p) X_pq^T,  E = sum_i V_i psi(F_i) + s/2 mu_i sum_e w_e |u_q - u_p - H
  ///   X_pq|^2
  /// with H = F_i - I. set_material gives such a body its masses. 14 neighbours are enough (2-D: 8); where there are
  /// fewer, theirs are taken too.
  particle_averaged
};

/// How the reaction to the force F_i = k_i (P*_i - x_i) on a particle is distributed to its neighbours.
enum class Reaction {
  full,         ///< -F_i to each neighbour: as in the thesis. Diverges on all but the smallest bodies.
  shared,       ///< -F_i / Nc_i to each: conserves linear momentum; oscillations grow without damping
  barycentric,  ///< -alpha_ij F_i to each: conserves linear momentum; oscillations grow without damping
  averaged,     ///< exact -dE/dx of sum_i k_i/2 |P*_i - x_i|^2: conserves both momenta and energy; no bulk stiffness
  conservative  ///< exact -dE/dx of sum_i k_i/2 sum_t w_t |P*_t - x_i|^2: conserves both momenta and energy
};

/// Which triples of neighbours (pairs in 2-D) become bases.
enum class BaseSelection {
  all,             ///< every triple that has a plane
  thresholded,     ///< those above min_quality and within max_barycentric
  opposite_faces,  ///< faces opposite to the particle in the corner tetrahedra of its cells; sets the neighbours too
  fitted           ///< few of `thresholded`, chosen and weighted by non-negative least squares to be nearly isotropic
};

/// The energy of a volume ratio J, per unit rest volume; U(1) = U'(1) = 0, U''(1) = kappa for all.
enum class VolumeLaw {
  quadratic,  ///< kappa/2 (J-1)^2
  bounded     ///< kappa s^2 (sqrt(1 + ((J-1)/s)^2) - 1), s = 0.4: U' stays below kappa s however far from rest
};

/// How the body gets the material's Poisson's ratio.
enum class PoissonRoute {
  volume_term,  ///< a volume energy per tetrahedron: any ratio in (-3/8, 1/2)
  /// beta_t [2/(1+(A_t/A_t0)^2)]^p in place of beta_t, with p from the ratio, which must be in (-0.375, 0.42]. No extra
  /// term. Young's modulus is exact on lattices of cubes and 3-5 % too low on unstructured tetrahedra.
  area_exponent
};

/// What build_topology does with a particle that has no base.
enum class SparseParticle {
  error,    ///< throws Error with the particles
  springs,  ///< springs to its neighbours, of stiffness k_i
  free      ///< no elastic force of its own
};

struct TopologyOptions {
  Law law = Law::shape_memory;
  Reaction reaction = Reaction::conservative;
  BaseSelection bases = BaseSelection::thresholded;
  double min_quality = 0.05;  ///< thresholded, fitted: 2 A / L^2 of a base (A its area, L its longest edge) above this
  double max_barycentric = 1.25;  ///< thresholded, fitted: |lambda| within this
  double area_exponent = 0.0;     ///< p; overwritten by the material where poisson_route is area_exponent
  PoissonRoute poisson_route = PoissonRoute::volume_term;
  VolumeLaw volume_law = VolumeLaw::bounded;
  /// Volume stiffness kappa in Pa where the model has no material (springs, or stiffness in N/m); 0: no volume term.
  double volume_stiffness = 0.0;
  /// gamma in [0, 1): least share of a cell's energy that is computed from its mean deformation instead of its bases.
  /// A value above 0 needs a material. Use 0.9 for hexahedra or wedges that bend: with 0 they lock, and a cantilever 4
  /// cells across bends 24 % too little at a Poisson's ratio of 0.3. With 0.9 the error is below 2 %
  /// (docs/guide/choosing.md). With PoissonRoute::volume_term and opposite_faces, cells whose base normals are not
  /// distributed isotropically (every tetrahedron, flat hexahedra, wedges; not cubes) get a larger share automatically,
  /// up to 0.9. Otherwise irregular tetrahedra would lose 16 % of Young's modulus.
  double cell_average = 0.0;
  /// s of Law::particle_averaged. Without a value it is calibrated so that pure bending of the body costs what it
  /// should (0.1 to 0.7; one value for each type of cell), and build_topology writes the mean over the volume here.
  std::optional<double> stabiliser = std::nullopt;
  SparseParticle on_sparse = SparseParticle::error;
  int max_texture_size = 16384;  ///< texels: limit of a GPU on the sides of a table
};

struct TopologyTextures;

/// Builds the tables. For a model with a material:
/// - k_i, w_t and the volume term are computed from it.
/// - The law must be particle_averaged, or shape_memory with Reaction::conservative in three dimensions. (For the other
///   laws clear Model::materials; masses stay.)
/// - TopologyOptions::bases has an effect only if it is `fitted`. The bases are `fitted` in two cases: if that was
///   chosen, or if the body consists of tetrahedra and the route is PoissonRoute::area_exponent. In all other cases
///   they are opposite_faces.
/// Throws Error for options that contradict each other or the model, and if a table is larger than max_texture_size
/// squared.
TopologyTextures build_topology(const Model& model, const TopologyOptions& options = {});

/// Isotropic theory of small strains. A body with deformation gradient F has the energy density c/2 |F n0 - n(F)|^2,
/// averaged over all rest normals n0, with n(F) the deformed unit normal, plus kappa/2 (J-1)^2 with J = det F. Its Lame
/// constants are mu = 7/15 c and lambda = kappa - c/5.
struct Calibration {
  double c = 0.0;         ///< Pa
  double kappa = 0.0;     ///< Pa; 0 for the area exponent
  double exponent = 0.0;  ///< p; 0 for the volume term
};

/// Throws Error if Poisson's ratio is out of the route's range.
Calibration calibrate(const Material& material, PoissonRoute route);

}  // namespace phymul
