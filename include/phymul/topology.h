// SPDX-License-Identifier: MIT
//
// How a Model becomes the constant tables of a simulation (topology_textures.h): the elastic law and its options.
//
// Notation, used by every kernel:
//   x_i, X_i    position of particle i now and at rest, m
//   Nc_i, Bc_i  number of neighbours, number of bases of particle i
//   k_i         shape stiffness, N/m: Model::stiffness
//   t = (a,b,c) a base of i: three particles (two in 2-D) around it
//   n_t         unit normal of t: (x_b - x_a) x (x_c - x_a), normalised (2-D: left normal of x_b - x_a)
//   lambda_t    barycentric coordinates in t of the projection of X_i on its plane, rest shape, sum 1
//   beta_t      signed height of X_i over t, m, rest shape
//   A_t, A_t0   area of t now and at rest
//   w_t         weight of t among the bases of i, sum 1: 1 / Bc_i
//   alpha_ij    sum over t of w_t lambda_t at vertex j, rest shape, sum over j = 1
//   P*_t        position that base t predicts for i: sum_v lambda_tv x_v + beta_t n_t
//   P*_i        attractor, their mean: sum_t w_t P*_t = sum_j alpha_ij x_j + sum_t w_t beta_t n_t
// "The thesis" is the one of 2007 that introduced this model (docs/README.md).
#pragma once

#include <phymul/model.h>
#include <phymul/task_runner.h>

#include <cstdint>
#include <memory>
#include <optional>

namespace phymul {

enum class Law {
  springs,       ///< stiffness in N/m
  shape_memory,  ///< the thesis' model: bases, stiffness in N/m
  /// One deformation gradient per particle, the mean over its neighbourhood. Needs a material. With shape functions N_i
  /// of the cells and displacements u:
  ///   V_i = integral of N_i,  C_ij = integral of N_i grad N_j,  F_i = I + 1/V_i sum_j (u_j - u_i) C_ij^T
  ///   E = sum_i V_i psi(F_i) + s/2 (integral of mu |F|^2 - sum_i mu_i V_i |F_i|^2)
  /// psi is TopologyOptions::strain_energy, J/m^3. The second term, of weight s (TopologyOptions::stabiliser), is the
  /// energy that the means lack. Where materials meet, a particle has a mean and an energy for each. 2-D: plane strain.
  /// A body of points, without cells that fill space, has one material and V_i = mass / density. Edges e = pq lead from
  /// i to its neighbours or between two of these, with weights w > 0 such that sum_e w_e X_pq X_pq^T = V_i I;
  /// H = F_i - I:
  ///   F_i = I + 1/V_i sum_e w_e (u_q - u_p) X_pq^T
  ///   E = sum_i V_i psi(F_i) + s/2 sum_i mu_i sum_e w_e |u_q - u_p - H X_pq|^2
  /// set_material computes the masses of such a body. 14 neighbours are enough (2-D: 8). Particles with fewer also use
  /// the neighbours of their neighbours.
  particle_averaged,
  /// Thin walls: triangles in space whose material has a thickness t. Of each triangle, of area A, and the vertices
  /// across its sides, one deformation gradient F (3 x 2), normal n and second derivatives of the positions x_,ab, all
  /// in an orthonormal frame of the triangle at rest:
  ///   E = sum A t psi(F) + t^3/24 sum A k : C k,   k_ab = n . x_,ab - N . X_,ab
  /// psi is StrainEnergy::neo_hookean in plane stress, C its moduli at rest (docs/theory/physics.md). An edge with one
  /// triangle is free, or clamped (clamp_edges() in wall.h). A body that has volume cells with a material as well has
  /// the law particle_averaged, and its walls besides.
  walls
};

/// How the reaction to the force F_i = k_i (P*_i - x_i) on a particle is distributed to its neighbours. Of
/// Law::shape_memory; a model with a material needs `conservative`.
enum class Reaction {
  full,         ///< -F_i to each neighbour: as in the thesis. Diverges on all but the smallest bodies.
  shared,       ///< -F_i / Nc_i to each: conserves linear momentum; oscillations grow without damping
  barycentric,  ///< -alpha_ij F_i to each: conserves linear momentum; oscillations grow without damping
  averaged,     ///< exact -dE/dx of sum_i k_i/2 |P*_i - x_i|^2: conserves both momenta and energy; no bulk stiffness
  conservative  ///< exact -dE/dx of sum_i k_i/2 sum_t w_t |P*_t - x_i|^2: conserves both momenta and energy
};

/// Which triples of neighbours (pairs in 2-D) become bases, of Law::shape_memory.
enum class BaseSelection {
  all,         ///< every triple that has a plane
  thresholded  ///< those above min_quality and within max_barycentric
};

/// The energy U of a volume ratio J, J/m^3; U(1) = U'(1) = 0, U''(1) = kappa for both.
enum class VolumeLaw {
  quadratic,  ///< kappa/2 (J-1)^2
  bounded     ///< the same for J from 0.5 to 1.5, and linear beyond: |U'| is at most kappa / 2
};

/// Energy density psi of a material, J/m^3, at a deformation gradient F, J = det F. mu and K are the shear modulus and
/// the bulk modulus; U is VolumeLaw at kappa = 1. Without the fibres both are the same for small strains.
enum class StrainEnergy {
  /// mu/2 (J^(-2/3) tr(F^T F) - 3) + K U(J) wherever the principal stretches are between 0.6 and 1.7, and somewhat
  /// beyond. Far from there, inverted or not, it is mu (tr(F^T F) / 2 - 2.5 d + 1.5) + K U(J) with
  /// d = sqrt(3) J / |cof F|, so that flattened, mirrored and overstretched bodies return (docs/theory/physics.md). The
  /// passage is smooth.
  neo_hookean,
  /// neo_hookean, plus k/8 (|F a|^2 - 1)^2 along fibres a, k = (fibre_ratio - 1) E (the standard reinforcing energy:
  /// Qiu and Pence 1997). build_topology uses it if a material has fibres.
  fibres,
  /// mu/2 [(1 - k) X + k (e^(b X) - 1) / b + c (Y - X) / (1 + d X)] + K U(J) where neo_hookean is exact, with
  /// X = J^(-2/3) tr(F^T F) - 3, Y = J^(-4/3) |cof F|^2 - 3, and k, b, c, d of Material::stiffening. Above b X = 4 the
  /// exponential is replaced by its tangent. Beyond, X is the former energy over mu/2 without K U(J), and the last term
  /// fades. build_topology uses it if a material has stiffening. It is the law of Mooney and Rivlin if k = d = 0, of
  /// Demiray if k = 1, c = 0, and of Veronda and Westmann (1970) if k + c = 1, d = 0.
  stiffening
};

/// What build_topology does with a particle that has no base.
enum class SparseParticle {
  error,    ///< throws Error with the particles
  springs,  ///< springs to its neighbours, of stiffness k_i
  free      ///< no elastic force of its own
};

struct TopologyOptions {
  /// Empty: particle_averaged for a model whose volume cells have a material, or that is a body of points with one;
  /// walls where only triangles with a thickness have one; else shape_memory. build_topology writes the law used into
  /// TopologyTextures::options.
  std::optional<Law> law = std::nullopt;
  Reaction reaction = Reaction::conservative;
  BaseSelection bases = BaseSelection::thresholded;
  double min_quality = 0.05;      ///< [0, 1), thresholded: least 2 A / L^2 of a base, of area A and longest edge L
  double max_barycentric = 1.25;  ///< > 0, thresholded: largest |lambda|
  StrainEnergy strain_energy = StrainEnergy::neo_hookean;  ///< of Law::particle_averaged
  VolumeLaw volume_law = VolumeLaw::bounded;
  /// Volume stiffness kappa, Pa, >= 0, of a model without a material (springs, or stiffness in N/m). 0: no volume term.
  double volume_stiffness = 0.0;
  /// s of Law::particle_averaged, >= 0. Empty: calibrated so that pure bending of each connected part has the correct
  /// energy (0.25 to 0.7; one value for each part and type of cell). build_topology then writes the mean over the
  /// volume into TopologyTextures::options.
  std::optional<double> stabiliser = std::nullopt;
  SparseParticle on_sparse = SparseParticle::error;
  /// Threads of the host that build the tables and estimate the spectrum of the body. The tables keep the pointer.
  /// Empty: a second thread is started if it saves time.
  std::shared_ptr<TaskRunner> runner{};
};

struct TopologyTextures;

/// Builds the tables. A model with a material takes Law::particle_averaged and no other (clear Model::materials to use
/// one; masses stay). Throws Error for an invalid model (validate), for options out of range or that contradict each
/// other or the model, for particles without a base or volume (SparseParticle::error), and if a table has more rows
/// than 32-bit numbers count.
TopologyTextures build_topology(const Model& model, const TopologyOptions& options = {});

}  // namespace phymul
