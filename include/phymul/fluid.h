// SPDX-License-Identifier: MIT
//
// Fluid inside a closed surface of particles: Scene::constrain_volume. Pressures are over that outside.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace phymul {

/// How the pressure p follows from the ratio r of the volume that the fluid has to the one it has without pressure.
enum class FluidLaw {
  incompressible,  ///< r is 1, whatever p
  gas,             ///< p = P (r^-n - 1) with P and n of Fluid; below -0.9 P its tangent
  curve            ///< linear between the points of Fluid::curve, and beyond them as in the last piece
};

struct Fluid {
  FluidLaw law = FluidLaw::incompressible;
  double outer_pressure = 101325.0;  ///< P of a gas, Pa, > 0: absolute, outside
  double exponent = 1.0;             ///< n of a gas, >= 1: 1 at constant temperature, 1.4 for fast changes of air
  std::vector<std::array<double, 2>> curve{};  ///< two points or more of r > 0, rising, and p, Pa, falling
  /// m^3/(Pa s), >= 0: an opening, through which fluid leaves at conductance * (p - outlet_pressure), or comes in where
  /// that is negative; as the volume it has without pressure. 0: closed.
  double conductance = 0.0;
  double outlet_pressure = 0.0;  ///< Pa, behind the opening
  /// Name of another volume that is behind the opening: what leaves goes there, by the difference of both pressures,
  /// and outlet_pressure is 0. Any number of openings lead into one. Empty: the opening leads outside.
  std::string opens_into{};
  bool operator==(const Fluid&) const = default;
};

/// The fluid in a surface after the last step.
struct FluidState {
  std::string name;       ///< VolumeConstraint::name
  double volume = 0.0;    ///< m^3, that it has without pressure; changes where there is an opening
  double pressure = 0.0;  ///< Pa
  /// Pa, of a gas or a curve: at the start of the step, for which the next one needs it. -0: the next one is its first.
  double pressure_before = 0.0;
  bool operator==(const FluidState&) const = default;
};

}  // namespace phymul
