// SPDX-License-Identifier: MIT
//
// The volume of a fluid at the end of a step as a function of how far its pressure pushes in it.
#pragma once

#include <phymul/fluid.h>

#include <algorithm>
#include <cmath>

#include "model/enclosed_volume.h"

namespace phymul {

/// r of a pressure, and its slope, 1/Pa: falling, finite everywhere.
inline WantedVolume fluid_ratio(const Fluid& fluid, double p) {
  if (fluid.law == FluidLaw::gas) {
    constexpr double least = -0.9;  // of P
    const double bounded = std::max(p / fluid.outer_pressure, least);
    const double r = std::pow(1.0 + bounded, -1.0 / fluid.exponent);
    const double slope = -r / (fluid.exponent * (1.0 + bounded) * fluid.outer_pressure);
    return {r + slope * (p - bounded * fluid.outer_pressure), slope};
  }
  if (fluid.law == FluidLaw::curve) {
    std::size_t k = 1;
    while (k + 1 < fluid.curve.size() && p < fluid.curve[k][1]) ++k;
    const auto& [r, high] = fluid.curve[k - 1];
    const auto& [next, low] = fluid.curve[k];
    const double slope = (next - r) / (low - high);
    return {r + slope * (p - high), slope};
  }
  return {1.0, 0.0};
}

/// p at a ratio.
inline double fluid_pressure(const Fluid& fluid, double r) {
  if (fluid.law == FluidLaw::gas) {
    const double edge = fluid_ratio(fluid, -0.9 * fluid.outer_pressure).volume;
    if (r <= edge) return fluid.outer_pressure * (std::pow(r, -fluid.exponent) - 1.0);
    return -0.9 * fluid.outer_pressure + (r - edge) / fluid_ratio(fluid, -0.9 * fluid.outer_pressure).slope;
  }
  if (fluid.law == FluidLaw::curve) {
    std::size_t k = 1;
    while (k + 1 < fluid.curve.size() && r > fluid.curve[k][0]) ++k;
    const auto& [from, high] = fluid.curve[k - 1];
    const auto& [to, low] = fluid.curve[k];
    return high + (r - from) * (low - high) / (to - from);
  }
  return 0.0;
}

/// Of what there is, that no step lets out.
inline constexpr double least_left = 1e-3;

/// Of a push s: s / dt^2 is the pressure of the step.
struct FluidPush {
  const Fluid& fluid;
  double volume = 0.0;  ///< m^3, without pressure, at the start
  double dt = 0.0;
  double before = 0.0, now = 0.0;  ///< Pa, p- and p, of a law of pressure
  double conductance = fluid.conductance;

  bool has_law() const { return fluid.law != FluidLaw::incompressible; }
  double pressure(double s) const {
    const double mean = s / (dt * dt);
    return has_law() ? 4.0 * mean - 2.0 * now - before : mean;
  }
  /// The push at a pressure at the end.
  double push(double p) const { return has_law() ? 0.25 * dt * dt * (p + 2.0 * now + before) : dt * dt * p; }
  double per_push() const { return (has_law() ? 4.0 : 1.0) / (dt * dt); }  ///< Pa
  /// m^3, without pressure, at the end.
  double left(double s) const {
    const double leaves = dt * conductance * (pressure(s) - fluid.outlet_pressure);
    return std::max(volume - leaves, least_left * volume);
  }
  WantedVolume operator()(double s) const {
    const double per_s = per_push(), has = left(s);
    const WantedVolume ratio = fluid_ratio(fluid, pressure(s));
    const double leaving = has > least_left * volume ? dt * conductance : 0.0;
    return {has * ratio.volume, per_s * (has * ratio.slope - leaving * ratio.volume)};
  }
};

}  // namespace phymul
