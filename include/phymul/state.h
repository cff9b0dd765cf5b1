// SPDX-License-Identifier: MIT
//
// State: where a body is. Plain data to copy, save and compare.
#pragma once

#include <phymul/model.h>
#include <phymul/tool.h>

#include <cstdint>
#include <string>
#include <vector>

namespace phymul {

struct State {
  double time = 0.0;  ///< s
  VecList position;   ///< [N] m
  /// [N] m/s: (position - previous position) / dt of the step that led here. In Verlet's scheme this is the velocity
  /// half a step before `time`.
  VecList velocity;
  /// Of the scene's tools. Solver::reset() takes those whose names the scene has; a tool without one starts at the
  /// scene's pose and holds nothing, whatever it was told to grasp before.
  std::vector<ToolState> tools{};

  bool operator==(const State&) const = default;
};

/// All that a solver's further steps depend on, but for the scene: put back into a solver over the same tables, of the
/// same backend, it goes on bit for bit. A State alone does in double precision, but for run_to_rest() and energy().
struct Snapshot {
  State state;
  double last_dt = 0.0;   ///< s, of the step that led here; 0: none did
  int steps_at_rest = 0;  ///< steps on end that were within the rest test
  /// [N] m, or empty: displacements from rest of a backend in single precision. position = rest + displacement is
  /// rounded, to a few parts in 1e16 of the distance from the origin, and loses what is smaller.
  VecList displacement;
  /// What others of the solver's parts remember, each under a name of its own.
  struct Part {
    std::string name;
    std::vector<std::uint8_t> bytes;
    bool operator==(const Part&) const = default;
  };
  std::vector<Part> parts;
  /// Solver::topology_hash() of the solver it was taken from. 0: unknown, and Solver::restore() does not check it.
  std::uint64_t topology_hash = 0;
  std::string backend;  ///< Solver::name() of that solver; empty: unknown

  bool operator==(const Snapshot&) const = default;
};

/// The rest shape, not moving, at time 0.
State rest_state(const Model& model);

/// True when time and every coordinate is finite.
bool is_finite(const State& state);

}  // namespace phymul
