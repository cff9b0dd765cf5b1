// SPDX-License-Identifier: MIT
//
// State: positions and velocities of a body. Plain data to copy, save and compare.
#pragma once

#include <phymul/body_cut.h>
#include <phymul/fluid.h>
#include <phymul/joint.h>
#include <phymul/model.h>
#include <phymul/thread.h>
#include <phymul/tool.h>

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
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
  /// Of the scene's threads, by name. Solver::reset() ignores names that the scene does not have. A thread without an
  /// entry starts as it was added.
  std::vector<ThreadState> threads{};
  /// Of the scene's volume constraints, by name; not of the backends gl and gl-compute. Solver::reset() ignores names
  /// that the scene does not have. A fluid without an entry is as much as VolumeConstraint::volume.
  std::vector<FluidState> fluids{};

  bool operator==(const State&) const = default;
};

/// The tools, joints and threads of a scene, by name and in its order.
struct SceneParts {
  std::vector<std::pair<std::string, Tool>> tools{};
  std::vector<std::pair<std::string, Joint>> joints{};
  std::vector<SceneThread> threads{};
};
/// The first tool, joint or thread that only one of them has, or that has other constants, as `tool "name"`; empty:
/// none. Tools are compared without Tool::pose, their first pose, threads without SceneThread::control.
std::string difference(const SceneParts& a, const SceneParts& b);
inline bool operator==(const SceneParts& a, const SceneParts& b) {
  return difference(a, b).empty();
}

/// Part of a Snapshot: where a tool goes, and what the last step reported of it.
struct ToolMemory {
  ToolPose target{};     ///< SceneTool::pose
  ToolPose last_pose{};  ///< ToolReport::last_pose
  ToolForce force{};
  bool operator==(const ToolMemory&) const = default;
};

/// Everything that the further steps of a solver depend on, except the scene's loads, gravity, contacts, volume
/// constraints and factors of stiffness. Restored in a solver of the same backend over the same tables, it continues
/// bit for bit. In double precision a State is enough for that, except for run_to_rest(), energy() and materials that
/// dissipate.
struct Snapshot {
  State state;
  double last_dt = 0.0;    ///< s, of the last step; 0: none
  int steps_at_rest = 0;   ///< number of consecutive steps up to the last one that passed the rest test
  double growth = 0.0;     ///< StepReport::growth of the last call; 0: there was none
  double max_speed = 0.0;  ///< m/s, of the last call
  /// [N] m, or empty: displacements from rest of a backend in single precision. rest + displacement, rounded to
  /// position, would lose bits of it.
  VecList displacement;
  /// A cell that a blade has passed, and the cut that it is to have, as in Cell::cuts.
  struct CutLater {
    Index cell = -1;  ///< row of Model::cells
    CellCut cut{};
    bool operator==(const CutLater&) const = default;
  };
  /// Of a Simulation, for Simulation::restore(): where its first step begins, if it has not stepped since it was made,
  /// set_state() or solve_static(). A Solver ignores it and starts from `state`.
  struct Start {
    VecList position{};                 ///< [N] m, or empty: there is none
    VecList velocity{};                 ///< [N] m/s, at State::time
    double dt = 0.0;                    ///< s, of the step before which State::velocity is; 0: those of State::time
    std::vector<CutLater> cut_later{};  ///< left by SimulationOptions::tick_budget, in order
    bool operator==(const Start&) const = default;
  };
  Start start;
  /// Further memory of a backend, each with its name.
  struct Part {
    std::string name;
    std::vector<std::uint8_t> bytes;
    bool operator==(const Part&) const = default;
  };
  std::vector<Part> parts;
  /// The scene's tools, joints and threads (Scene::parts()). Null: unknown, as in files written before snapshots had
  /// them; then restore() does not compare them with those of the scene.
  std::shared_ptr<const SceneParts> scene;
  std::vector<ToolMemory> tools;     ///< of scene->tools
  std::vector<JointReport> joints;   ///< of scene->joints
  std::vector<Index> removed_cells;  ///< TopologyTextures::removed
  BodyCuts cuts;                     ///< TopologyTextures::cuts
  /// Solver::topology_hash() of the solver it was taken from. 0: unknown, and Solver::restore() does not check it.
  std::uint64_t topology_hash = 0;
  std::string backend;  ///< Solver::name() of that solver; empty: unknown
};
inline bool operator==(const Snapshot& a, const Snapshot& b) {
  const auto members = [](const Snapshot& of) {
    return std::tie(of.state, of.last_dt, of.steps_at_rest, of.growth, of.max_speed, of.displacement, of.start,
                    of.parts, of.tools, of.removed_cells, of.joints, of.topology_hash, of.backend);
  };
  return members(a) == members(b) && equal_cuts(a.cuts, b.cuts) &&
         (a.scene && b.scene ? *a.scene == *b.scene : a.scene == b.scene);
}

/// The rest shape without motion, at time 0.
State rest_state(const Model& model);

/// True if the time and every coordinate are finite.
bool is_finite(const State& state);

}  // namespace phymul
