// SPDX-License-Identifier: MIT
//
// Edges around a particle without cells, weighted so that they look alike from all sides.
#pragma once

#include <phymul/types.h>

#include <vector>

namespace phymul {

/// Between two places of a neighbourhood: 0 is the particle, k its neighbour k - 1.
struct WeightedEdge {
  Index from, to;
  double weight;  ///< m (2-D: 1)
};

/// Weights w > 0 with sum of w e e^T = volume times the unit tensor over the edges e. With that
///   H = 1/volume sum of w (u_to - u_from) e^T
/// is a mean displacement gradient, exact for linear fields; and sum of w |u_to - u_from - H e|^2 is the same as
/// sum of w |u_to - u_from|^2 - volume |H|^2, never negative.
/// `r`: neighbours relative to the particle. Where those alone cannot be so weighted (on edges and corners of a body
/// they are all on one side) the edges between near neighbours join. Empty where nothing helps: the neighbours are in a
/// plane, or too few.
std::vector<WeightedEdge> isotropic_edges(const VecList& r, int dimension, double volume);

}  // namespace phymul
