// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <string>
#include <vector>

namespace phymul {

/// Throws Error for constants of dissipation out of their range.
void require_dissipation_in_range(const Material& material);

/// Throws Error unless the constants lie where the material model can reach them, those of dissipation included.
void require_in_range(const Material& material);

/// Orders the materials by their first cell, and forgets those that no cell has: setting one again and again does not
/// pile them up.
void drop_unused_materials(Model& model);

/// Of StrainEnergy::stiffening: b X, above which the exponential is replaced by its tangent. e^4 = 55: what the
/// stiffness of that term can grow by, and with it the frequencies.
inline constexpr double most_exponent = 4.0;

/// What constants out of range are called; empty: none are. They are out of range if the stress of an incompressible
/// body of them does not rise with every stretch from 0.6 to 1.7 and every amount of shear to 1.
std::string fault_of(const Stiffening& stiffening);

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
