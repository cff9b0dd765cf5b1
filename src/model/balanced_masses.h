// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <vector>

namespace phymul {

struct MassBalance {
  double moved = 0.0;  ///< share of the mass
  double gain = 1.0;   ///< estimate of the factor by which the stable step is longer
};

/// Moves mass to particles that have little of it for their stiffness from those with which they share a cell, so that
/// no single particle sets the stable step (mass scaling; here the body keeps its mass). A particle's own block of the
/// stiffness over its mass is bounded by one number for all, the smallest that Model::most_mass_moved allows. Total
/// mass, centre of mass and moments of inertia are kept but for rounding. `mass` [N] kg; particles of mass 0 are left
/// out. Nothing changes where it would gain less than a twentieth.
MassBalance balance_masses(const Model& model, std::vector<double>& mass);

}  // namespace phymul
