// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <string>

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

}  // namespace phymul
