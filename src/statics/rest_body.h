// SPDX-License-Identifier: MIT
//
// What searches for rest need of a body of which certain coordinates are imposed, whatever its state, loads and terms
// are: its forces, and tangent, grids and paths, which take longer to make than a search takes.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "multigrid.h"
#include "rest_changes.h"
#include "rest_term.h"
#include "turning_path.h"

namespace phymul {

/// Refers to the tables, which must not change.
class RestBody {
 public:
  /// `fixed`: as LoadFrame::fixed. Throws Error for tables beyond the range of single precision.
  RestBody(const TopologyTextures& topology, std::span<const std::uint8_t> fixed);
  RestBody(const RestBody&) = delete;
  RestBody& operator=(const RestBody&) = delete;

  std::span<const Mat3> diagonal() const { return diagonal_; }  ///< [N] N/m, diagonal_at_rest()

  /// Adds elastic forces at x, [N] m, to `force`, [N] N; and the mean gradients there, of all domains.
  void add_forces(const VecList& x, std::span<Vec3> force, std::vector<Mat3>& gradients);
  /// Mean gradients of a displacement, [3 N] m.
  void find_gradients(const Eigen::VectorXd& displacement, std::vector<Mat3>& gradients);

 private:
  friend class RestSearch;
  const TopologyTextures& topology_;
  std::vector<Mat3> diagonal_;
  std::unique_ptr<Tangent> tangent_;
  Multigrid grid_;
  TurningPath path_;
  VecList of_domains_;  // displacements of their particles, side by side: sums over neighbours read them many times

  // Of searches that predict:
  RestChanges changes_;
  std::vector<Mat3> turned_at_;  // mean gradients that grid_ is turned to; empty: to none
};

/// N, on particle i of so much mass, kg.
inline Vec3 load_on(std::span<const double> mass, const LoadFrame& loads, std::size_t i) {
  const Vec3 weight = mass[i] * loads.gravity;
  return loads.force.empty() ? weight : Vec3(weight + loads.force[i]);
}

/// J: elastic, less the work of the loads from the rest shape on.
double potential_energy(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                        const VecList& position);

}  // namespace phymul
