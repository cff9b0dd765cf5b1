// SPDX-License-Identifier: MIT
//
// Fluids in a step. FluidPush: the volume of one at the end as a function of how far its pressure pushes.
// FluidExchange: how much of each is at the end in volumes that are connected.
#pragma once

#include <phymul/fluid.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "model/closed_surface.h"

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

/// Of what there is, that no step lets out; and of VolumeConstraint::volume, so that many steps do not let out all.
inline constexpr double least_left = 1e-3, least_of_whole = 1e-10;

/// Of a push s: s / dt^2 is the pressure of the step.
struct FluidPush {
  const Fluid& fluid;
  double volume = 0.0;  ///< m^3, without pressure, at the start
  double dt = 0.0;
  double before = 0.0, now = 0.0;  ///< Pa, p- and p, of a law of pressure
  double conductance = fluid.conductance;
  double whole = 0.0;  ///< m^3, VolumeConstraint::volume

  bool has_law() const { return fluid.law != FluidLaw::incompressible; }
  double pressure(double s) const {
    const double mean = s / (dt * dt);
    return has_law() ? 4.0 * mean - 2.0 * now - before : mean;
  }
  /// The push at a pressure at the end.
  double push(double p) const { return has_law() ? 0.25 * dt * dt * (p + 2.0 * now + before) : dt * dt * p; }
  double per_push() const { return (has_law() ? 4.0 : 1.0) / (dt * dt); }                                   ///< Pa
  double least() const { return std::min(std::max(least_left * volume, least_of_whole * whole), volume); }  ///< m^3
  /// m^3, without pressure, at the end.
  double left(double s) const {
    const double leaves = dt * conductance * (pressure(s) - fluid.outlet_pressure);
    return std::max(volume - leaves, least());
  }
  WantedVolume operator()(double s) const {
    const double per_s = per_push(), has = left(s);
    const WantedVolume ratio = fluid_ratio(fluid, pressure(s));
    const double leaving = has > least() ? dt * conductance : 0.0;
    return {has * ratio.volume, per_s * (has * ratio.slope - leaving * ratio.volume)};
  }
};

/// How much fluid each of some connected volumes has at the end of a step. Into volume i fits, at the pressure p at the
/// end, phi_i(p) = V_i(s(p)) / r_i(p) of its fluid (FluidPush), which rises with p. With G the conductances between
/// them and L their Laplacian, which has the openings to the outside on its diagonal,
///
///     phi_i(p_i) + dt (L p)_i = m_i + dt G_out,i p_out,i          m: the fluid at the start
///
/// is the gradient of a convex function: Newton's method with a line search finds its one root, at any conductance.
class FluidExchange {
 public:
  struct Volume {
    FluidPush push;                                   // closed, with the fluid at the start
    double reached = 0.0;                             // m^3, without a push
    std::array<double, 3> along{};                    // volume_along()
    double conductance = 0.0, outlet_pressure = 0.0;  // to the outside
    double p = 0.0;                                   // Pa: where to start; then the root
    // Found by solve(). Beyond `low` and `high`, Pa, phi is continued by lines. Below `low` no fluid is left to give:
    // the volume keeps `least`, as flat as it is or so little that it cannot give more, and p is what sucks at it.
    double low = 0.0, high = 0.0, least = 0.0;  // Pa, Pa, m^3
    bool flat = false, dry = false;
    double left = 0.0;  // m^3, at the end

    WantedVolume fits(double pressure) const;  ///< phi and its slope
    void find_ends();
  };
  struct Link {
    int from, to;  // rows of `volumes`
    double conductance;
  };
  std::vector<Volume> volumes;  ///< refilled in each step
  std::vector<Link> links;

  void allocate(int count);
  /// The row of a volume that cannot hold what it would have; -1: none.
  int solve();

 private:
  double residual(const Eigen::VectorXd& p, Eigen::VectorXd& to) const;  ///< its greatest component
  enum class Found { root, rigid, nothing };                             // rigid: nothing yields to a pressure
  Found find_root();
  void share_out();

  Eigen::MatrixXd slope_;
  Eigen::VectorXd p_, trial_, off_, step_;
  Eigen::LDLT<Eigen::MatrixXd> factors_;
};

}  // namespace phymul
