// SPDX-License-Identifier: MIT
//
// Choices that turn a Model into the constant tables of a simulation (topology_textures.h).
//
// Notation, used by every kernel:
//   x_i, X_i    position of particle i now and at rest, m
//   k_i         shape stiffness, N/m
//   t = (a,b,c) a base of i: three particles (two in 2-D) around it
//   n_t         unit normal of t: (x_b - x_a) x (x_c - x_a), normalised (2-D: left normal of x_b - x_a)
//   lambda_t    barycentric coordinates in t of the projection of X_i on its plane, rest shape, sum 1
//   beta_t      signed height of X_i over t, m, rest shape
//   w_t         weight of t among the bases of i, sum 1 (1 / Bc_i where none is wanted)
//   alpha_ij    sum over t of w_t lambda_t at vertex j, rest shape, sum over j = 1
//   P*_i        attractor: sum_j alpha_ij x_j + sum_t w_t beta_t n_t
#pragma once

#include <phymul/model.h>

#include <cstdint>

namespace phymul {

enum class Law { springs, shape_memory };

/// How the force F_i = k_i (P*_i - x_i) on a particle is given back to its neighbours.
enum class Reaction {
  full,         ///< -F_i to each neighbour: the thesis, literally. Grows without bound on all but the smallest bodies.
  shared,       ///< -F_i / Nc_i to each: keeps linear momentum; flutters undamped
  barycentric,  ///< -alpha_ij F_i to each: keeps linear momentum; flutters undamped
  averaged,     ///< exact -dE/dx of sum_i k_i/2 |P*_i - x_i|^2: keeps both momenta and energy; no bulk stiffness
  conservative  ///< exact -dE/dx of sum_i k_i/2 sum_t w_t |P*_t - x_i|^2: keeps both momenta and energy
};

/// Which triples of neighbours (pairs in 2-D) become bases.
enum class BaseSelection {
  all,             ///< every triple that has a plane
  thresholded,     ///< those above min_quality and within max_barycentric
  opposite_faces,  ///< faces of the incident cells' corner tetrahedra, opposite to the particle; neighbours follow
  fitted           ///< the sparse non-negative least-squares subset of `thresholded` nearest to elastic isotropy
};

/// The energy of a volume ratio J, per unit rest volume; U(1) = U'(1) = 0, U''(1) = kappa for all.
enum class VolumeLaw {
  quadratic,  ///< kappa/2 (J-1)^2
  bounded     ///< kappa s^2 (sqrt(1 + ((J-1)/s)^2) - 1), s = 0.4: U' stays below kappa s however far from rest
};

/// How the material's Poisson's ratio is met.
enum class PoissonRoute {
  volume_term,   ///< a volume energy per tetrahedron: any ratio in (-3/8, 1/2)
  area_exponent  ///< beta_t [2/(1+(A_t/A_t0)^2)]^p with p from the ratio: -0.375 to 0.42 (p = 2); no extra
                 ///< term. E exact on lattices of cubes, 3-5 % low on unstructured tetrahedra
};

/// What to do with a particle that has no base.
enum class SparseParticle {
  error,    ///< throw, naming particles
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
  /// Least share gamma in [0, 1) of a cell's energy that is taken from its mean deformation; > 0 needs a material and
  /// cures bending of hexahedra and wedges from locking; 0.9 is a good value. With PoissonRoute::volume_term and bases
  /// from opposite_faces, cells whose base normals are far from isotropic take more by themselves, up to 0.9: every
  /// tetrahedron, flat hexahedra, wedges; not cubes. Without that, jittered tetrahedra lose 16 % of Young's modulus.
  /// 0 is the model per base, the default. Hexahedra or wedges with a material that may bend want 0.9: without it they
  /// lock, and a cantilever of 4 cells across bends 24 % too little at nu 0.3, 30 % at 0.45; with it within 2 %
  /// (docs/choosing.md, docs/accuracy.md).
  double cell_average = 0.0;
  SparseParticle on_sparse = SparseParticle::error;
  int max_texture_size = 16384;  ///< widest and highest table a device takes, texels
};

struct TopologyTextures;

/// Builds the tables. Where the model has a material, k_i, w_t and the volume term follow from it for
/// Law::shape_memory with Reaction::conservative (any other reaction cannot carry a calibrated material: Error).
/// A model with a material must be three-dimensional (in 2-D clear Model::materials; the masses stay), and takes its
/// bases from opposite_faces; from `fitted` where that is asked for, or where a body
/// of tetrahedra is to meet Poisson's ratio by the area exponent. Throws Error, also when a
/// table outgrows max_texture_size squared (with the sizes).
TopologyTextures build_topology(const Model& model, const TopologyOptions& options = {});

/// The calibration by itself, isotropic theory of small strains: energy density c/2 |F n0 - n(F)|^2 averaged over all
/// directions, plus kappa/2 (J-1)^2, has the Lame constants mu = 7/15 c and lambda = kappa - c/5.
struct Calibration {
  double c = 0.0;         ///< Pa
  double kappa = 0.0;     ///< Pa; 0 for the area exponent
  double exponent = 0.0;  ///< p; 0 for the volume term
};

/// Throws Error when the ratio is out of the route's range.
Calibration calibrate(const Material& material, PoissonRoute route);

}  // namespace phymul
