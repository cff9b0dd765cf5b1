// SPDX-License-Identifier: MIT
//
// How fast a body whose reaction takes no energy into account grows by itself: predicted by its eigenvalues, and
// measured by running it.
#pragma once

#include <phymul/phymul.h>

#include <algorithm>
#include <complex>
#include <limits>
#include <memory>

#include "dense_operator.h"

namespace phymul::test {

struct GrowthRate {
  double predicted = 0.0;  ///< 1/s
  double measured = 0.0;   ///< 1/s, of an undamped run; NaN where the body does not grow
  double frequency = 0.0;  ///< 1/s, angular frequency of the growing motion; 0: it grows without swinging
  double highest = 0.0;    ///< 1/s, highest angular frequency of the body
};

/// Below this share of the highest frequency a rate is the rounding of the eigenvalues: sqrt of 1e-8.
inline constexpr double least_growth = 1e-4;

inline State moving_in(const GrowingMode& mode, const Model& model, double amplitude) {
  State state = rest_state(model);
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    for (int axis = 0; axis < model.dimension; ++axis) {
      const std::complex<double> part = amplitude * mode.shape[static_cast<Eigen::Index>(3 * i) + axis];
      state.position[i][axis] += part.real();
      state.velocity[i][axis] = (mode.s * part).real();
    }
  }
  return state;
}

inline double amplitude_of(const GrowingMode& mode, const Model& model, const State& state) {
  Eigen::VectorXcd u(mode.shape.size());
  for (Eigen::Index k = 0; k < u.size(); ++k) {
    const auto i = static_cast<std::size_t>(k / 3);
    u[k] = state.position[i][k % 3] - model.rest[i][k % 3];
  }
  return std::abs((mode.picks * u)(0));
}

/// Starts in the fastest growing mode, small enough to stay linear, and lets it grow by e to the third.
inline GrowthRate growth_rate(const Model& model, std::shared_ptr<const TopologyTextures> topology) {
  const GrowingMode mode = fastest_growing_mode(*topology);
  GrowthRate rate{mode.s.real(), std::numeric_limits<double>::quiet_NaN(), 0.0, mode.highest_frequency};
  if (rate.predicted < least_growth * mode.highest_frequency) {
    rate.predicted = 0.0;
    return rate;
  }
  rate.frequency = std::abs(mode.s.imag());
  const Scene scene(model);
  const auto solver = make_solver("reference", std::move(topology), scene);
  const double dt = 0.1 / mode.highest_frequency;
  const int steps = std::max(20, static_cast<int>(3.0 / (rate.predicted * dt)));
  solver->start(moving_in(mode, model, 1e-6 * mean_spacing(model)), dt);
  const double before = amplitude_of(mode, model, solver->read());
  const StepReport report = solver->step(steps, dt);
  if (!report.ok()) return rate;
  rate.measured = std::log(amplitude_of(mode, model, solver->read()) / before) / report.time;
  return rate;
}

}  // namespace phymul::test
