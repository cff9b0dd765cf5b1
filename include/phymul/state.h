// SPDX-License-Identifier: MIT
//
// State: positions and velocities of a body. Plain data to copy, save and compare.
#pragma once

#include <phymul/joint.h>
#include <phymul/model.h>
#include <phymul/tool.h>

#include <cstdint>
#include <string>
#include <vector>

namespace phymul {

struct State {
  double time = 0.0;  ///< s
  VecList position;   ///< [N] m
  /// [N] m/s: (position - previous position) / dt of the last step. In Verlet's scheme this is the velocity half a step
  /// before `time`.
  VecList velocity;
  /// Of the scene's tools, by name. Solver::reset() ignores names that the scene does not have. A tool without an entry
  /// starts at the scene's pose and holds nothing.
  std::vector<ToolState> tools{};
  /// Joints with broken springs, by name. Solver::reset() ignores names that the scene does not have.
  std::vector<JointState> joints{};

  bool operator==(const State&) const = default;
};

/// Everything that the further steps of a solver depend on except the scene. Restored in a solver of the same backend
/// over the same tables, it continues bit for bit. In double precision a State is enough for that, except for
/// run_to_rest(), energy() and materials that dissipate.
struct Snapshot {
  State state;
  double last_dt = 0.0;    ///< s, of the last step; 0: none
  int steps_at_rest = 0;   ///< number of consecutive steps up to the last one that passed the rest test
  double growth = 0.0;     ///< StepReport::growth of the last call; 0: there was none
  double max_speed = 0.0;  ///< m/s, of the last call
  /// [N] m, or empty: displacements from rest of a backend in single precision. rest + displacement, rounded to
  /// position, would lose bits of it.
  VecList displacement;
  /// Further memory of a backend, each with its name.
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

/// The rest shape without motion, at time 0.
State rest_state(const Model& model);

/// True if the time and every coordinate are finite.
bool is_finite(const State& state);

}  // namespace phymul
