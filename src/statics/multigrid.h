// SPDX-License-Identifier: MIT
//
// One V-cycle of multigrid as an approximate inverse of the tangent stiffness: symmetric and positive where the tangent
// is. The finest level is the particles, smoothed by a damped sweep of Jacobi with the blocks of the diagonal of K at
// rest before and after; the others are grids (grid_level.h), smoothed by Gauss-Seidel, the coarsest solved directly.
#pragma once

#include <Eigen/Cholesky>
#include <span>
#include <vector>

#include "block_matrix.h"
#include "grid_level.h"
#include "rest_term.h"

namespace phymul {

/// [N] N/m: blocks of the diagonal of the tangent stiffness at rest.
std::vector<Mat3> diagonal_at_rest(const TopologyTextures& topology);

class Multigrid {
 public:
  /// Of the free coordinates. `fixed` [N]: as LoadFrame::fixed, or empty. `diagonal`: diagonal_at_rest(). Keeps
  /// references to the tables, the diagonal and the tangent.
  Multigrid(const TopologyTextures& topology, std::span<const std::uint8_t> fixed, std::span<const Mat3> diagonal,
            Tangent& tangent);

  /// To be called first, before each search: forgets the last one, so that the same search has the same bits. Keeps a
  /// reference to the terms. True if the last turn() was with stiffnesses of terms, now gone: it is to be done anew.
  bool begin(RestTerms terms);

  /// Takes the terms' stiffness as it is now, if it has changed by much since it last did; returns whether. Then
  /// turn() and estimate_largest() are to be called.
  bool follow_terms();

  /// Follows the tangent to another state: `gradients` [domains] as Tangent::linearise. To be called before solve().
  void turn(std::span<const Mat3> gradients);

  /// Looks for the largest eigenvalue of the scaled K, which the smoothing needs, by `steps` steps of the power
  /// iteration, an evaluation each. Goes on from where the last call ended. To be called before solve().
  void estimate_largest(int steps);

  /// result = K d on free coordinates, 0 on the others.
  void apply(const Eigen::VectorXd& d, Eigen::VectorXd& result);
  /// z: about K^-1 r.
  void solve(const Eigen::VectorXd& r, Eigen::VectorXd& z);

  const GridLevel& finest_of(Index most_nodes) const;    ///< the finest grid of at most so many nodes, or the coarsest
  int evaluations() const { return evaluations_; }       ///< of K
  const Eigen::VectorXd& free() const { return free_; }  ///< 1 or 0

 private:
  struct Coarse {
    GridLevel level;
    std::vector<GridPlace> finer;  // of particles, or of the nodes of the level before
    BlockMatrix stiffness;         // not of the coarsest
    PaddedVectors b, x, r;
  };

  void apply(const PaddedVectors& d, PaddedVectors& result);
  void scale(const PaddedVectors& r, PaddedVectors& z) const;
  void cycle(std::size_t level);
  void solve_coarsest();

  const TopologyTextures& topology_;
  Tangent& tangent_;
  RestTerms terms_;
  Eigen::VectorXd free_;
  PaddedVectors padded_free_;
  std::span<const Mat3> diagonal_;            // at rest, without terms
  std::vector<Mat3> of_terms_;                // RestTerm::add_diagonal() that the levels have
  std::vector<PaddedMatrix> turned_inverse_;  // of both, the first turned with the particles
  double typical_stiffness_ = 0.0;            // N/m, of a particle
  float largest_ = 1.0f;                      // eigenvalue of the scaled K
  std::vector<Coarse> coarse_;
  Eigen::LLT<Eigen::MatrixXd> direct_;  // of the coarsest level
  int evaluations_ = 0;
  PaddedVectors strongest_, of_r_, of_z_, image_, residual_, scaled_;
  Eigen::VectorXd coarsest_, of_d_, of_image_;
};

}  // namespace phymul
