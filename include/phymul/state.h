// SPDX-License-Identifier: MIT
//
// State: where a body is. Plain data to copy, save and compare.
#pragma once

#include <phymul/model.h>
#include <phymul/tool.h>

namespace phymul {

struct State {
  double time = 0.0;  ///< s
  VecList position;   ///< [N] m
  /// [N] m/s: (position - previous position) / dt of the step that led here. In Verlet's scheme this is the velocity
  /// half a step before `time`.
  VecList velocity;
  /// Of the scene's tools. Solver::reset() takes those whose names the scene has; a tool without one starts at the
  /// scene's pose and holds nothing.
  std::vector<ToolState> tools{};

  bool operator==(const State&) const = default;
};

/// The rest shape, not moving, at time 0.
State rest_state(const Model& model);

/// True when time and every coordinate is finite.
bool is_finite(const State& state);

}  // namespace phymul
