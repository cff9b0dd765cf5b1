// SPDX-License-Identifier: MIT
//
// State: where a body is. Plain data to copy, save and compare.
#pragma once

#include <phymul/model.h>

namespace phymul {

struct State {
  double time = 0.0;  ///< s
  VecList position;   ///< [N] m
  /// [N] m/s: (position - previous position) / dt of the step that led here. In Verlet's scheme this is the velocity
  /// half a step before `time`.
  VecList velocity;

  bool operator==(const State&) const = default;
};

/// The rest shape, not moving, at time 0.
State rest_state(const Model& model);

/// True when time and every coordinate is finite.
bool is_finite(const State& state);

}  // namespace phymul
