// SPDX-License-Identifier: MIT
//
// The stabiliser s of Law::particle_averaged, calibrated on the body itself: pure bending must cost what it should.
#pragma once

#include <vector>

#include "averaged_body.h"

namespace phymul {

/// No s below: rough motions would cost nothing.
inline constexpr double least_stabiliser = 0.1;

/// s for cells of one type.
struct CalibratedStabiliser {
  CellType type = CellType::tetrahedron;
  double value = 0.0;   ///< at least least_stabiliser
  double lowest = 0.0;  ///< of the bendings about the six pairs of axes (2-D: two), without that floor
  double highest = 0.0;
};

/// The bending u_a = x_a x_b, u_b = -(x_a^2 + nu (x_b^2 - x_c^2)) / 2, u_c = -nu x_b x_c about the body's centroid has
/// the energy E/2 integral of x_b^2 in linear elasticity. Put on the particles it costs the energy of the means, which
/// is too little, and s times that of the spread: s makes up the difference. In 2-D, where strain is plane, nu and E
/// are nu / (1 - nu) and E / (1 - nu^2), and c is none. Cells count with E = 1, so that soft ones are heard; one value
/// for each type of cell.
std::vector<CalibratedStabiliser> calibrated_stabilisers(const Model& model, const Domains& domains);

}  // namespace phymul
