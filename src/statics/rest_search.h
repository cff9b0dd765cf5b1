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

#include "rest_term.h"

namespace phymul {

struct RestSearchEnd {
  bool at_rest = false;
  bool stuck = false;  ///< no step along the last direction lowers the energy
  int evaluations = 0;
  double residual = 0.0, largest_force = 0.0;  ///< as of StaticResult
};

/// Takes `position`, [N] m, towards rest under `loads`, as Scene::evaluate() fills them, and terms; until the residual
/// is at most `tolerance` and terms miss their laws by no more, or after `most_evaluations` (a few more, because a line
/// search is not broken off). `loose`: the bodies that have free_motions(); along these they stay where the search
/// begins, unless something drives them. `diagonal`: diagonal_at_rest(). Throws Error for tables beyond the range of
/// single precision.
RestSearchEnd search_rest(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                          std::span<const ConnectedBody> loose, std::span<const Mat3> diagonal, double tolerance,
                          int most_evaluations, VecList& position);

/// N, on particle i of so much mass, kg.
inline Vec3 load_on(std::span<const double> mass, const LoadFrame& loads, std::size_t i) {
  const Vec3 weight = mass[i] * loads.gravity;
  return loads.force.empty() ? weight : Vec3(weight + loads.force[i]);
}

/// J: elastic, less the work of the loads from the rest shape on.
double potential_energy(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                        const VecList& position);

}  // namespace phymul
