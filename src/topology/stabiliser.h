// SPDX-License-Identifier: MIT
//
// The stabiliser s of Law::particle_averaged, calibrated on the body itself: pure bending must cost what it should.
#pragma once

#include <vector>

#include "averaged_body.h"

namespace phymul {

/// s for the cells of one type in one part of a body.
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
