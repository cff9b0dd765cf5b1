// SPDX-License-Identifier: MIT
//
// The rest shape of a body of Law::particle_averaged: Newton's method on its energy with a line search along curved
// paths (turning_path.h). The linear systems are solved by conjugate gradients, as far as the next step deserves it,
// with a V-cycle of multigrid (multigrid.h). Source: J. Nocedal and S. Wright, Numerical Optimization, ch. 3, 5 and 7.
#pragma once

#include <phymul/bodies.h>
#include <phymul/load_frame.h>
#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <span>

#include "multigrid.h"
#include "rest_term.h"
#include "turning_path.h"

namespace phymul {

struct RestSearchEnd {
  bool at_rest = false;
  bool stuck = false;  ///< no step along the last direction lowers the energy
  int evaluations = 0;
  double residual = 0.0, largest_force = 0.0;  ///< as of StaticResult
};

/// What searches need of a body of which these coordinates are imposed, whatever its state, loads and terms are. Refers
/// to the tables, which must not change.
class RestBody {
 public:
  /// `fixed`: as LoadFrame::fixed. Throws Error for tables beyond the range of single precision.
  RestBody(const TopologyTextures& topology, std::span<const std::uint8_t> fixed);
  RestBody(const RestBody&) = delete;
  RestBody& operator=(const RestBody&) = delete;

  std::span<const Mat3> diagonal() const { return diagonal_; }  ///< [N] N/m, diagonal_at_rest()

 private:
  friend class RestSearch;
  const TopologyTextures& topology_;
  std::vector<Mat3> diagonal_;
  std::unique_ptr<Tangent> tangent_;
  Multigrid grid_;
  TurningPath path_;
};

/// Takes `position`, [N] m, towards rest under `loads`, as Scene::evaluate() fills them, and terms; until the residual
/// is at most `tolerance` and terms miss their laws by no more, or after `most_evaluations` (a few more, because a line
/// search is not broken off). `loose`: the bodies that have free_motions(); along these they stay where the search
/// begins, unless something drives them. `body`: with what `loads` impose. The same search has the same bits, whatever
/// was searched for before.
RestSearchEnd search_rest(RestBody& body, const LoadFrame& loads, RestTerms terms, std::span<const ConnectedBody> loose,
                          double tolerance, int most_evaluations, VecList& position);

/// N, on particle i of so much mass, kg.
inline Vec3 load_on(std::span<const double> mass, const LoadFrame& loads, std::size_t i) {
  const Vec3 weight = mass[i] * loads.gravity;
  return loads.force.empty() ? weight : Vec3(weight + loads.force[i]);
}

/// J: elastic, less the work of the loads from the rest shape on.
double potential_energy(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                        const VecList& position);

}  // namespace phymul
