// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <string>

namespace phymul {

/// Of StrainEnergy::stiffening: b X, above which the exponential is replaced by its tangent. e^4 = 55: what the
/// stiffness of that term can grow by, and with it the frequencies.
inline constexpr double most_exponent = 4.0;

/// What constants out of range are called; empty: none are. They are out of range if the stress of an incompressible
/// body of them does not rise with every stretch from 0.6 to 1.7 and every amount of shear to 1.
std::string fault_of(const Stiffening& stiffening);

}  // namespace phymul
