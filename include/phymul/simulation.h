// SPDX-License-Identifier: MIT
//
// Simulation: one object that owns a model, its scene and its solver.
#pragma once

#include <phymul/recording.h>
#include <phymul/scene.h>
#include <phymul/solver.h>
#include <phymul/state_file.h>
#include <phymul/topology.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace phymul {

struct GroupMaterial {
  std::string group;  ///< applies to the cells all of whose particles are in it
  Material material{};
};

/// Makes the solver of a Simulation in place of make_solver(): for a backend of one's own.
using SolverFactory = std::function<std::unique_ptr<Solver>(std::shared_ptr<const TopologyTextures> topology,
                                                            const Scene& scene, const SolverOptions& options)>;

struct SimulationOptions {
  Material material{};                     ///< of every cell; left out, the model keeps the materials it has
  std::vector<GroupMaterial> materials{};  ///< of groups, set after `material` in this order
  std::string backend = "auto";            ///< a name that make_solver() takes
  Damping damping{};                       ///< replaces solver.damping unless it is left out
  double step = 0.5;                       ///< longest step of advance() over the solver's stable_step(), > 0
  TopologyOptions topology{};
  SolverOptions solver{};
  SolverFactory make_solver{};  ///< empty: phymul::make_solver() with `backend`
};

/// One of several bodies of a Simulation. Its groups get the names "<name>/<group>"; see merge_models().
struct SimulationBody {
  std::string name;
  Model model;
  Material material{};  ///< left out: SimulationOptions::material, or else what the model has
};

/// Owns a model, its scene and a solver. Movable, not copyable: references to the three and handles of tools stay valid
/// when a Simulation is moved. Threads: as for Solver.
///
/// The solver is made at its first use, so that "auto" can choose by the scene as it is then; fill the scene first. All
/// functions that use the solver throw Error if it cannot be made; apart from that, advance() and run_to_rest() report
/// failures and do not throw.
class Simulation {
 public:
  /// Sets the materials and builds the tables. Throws Error as set_material(), Scene and build_topology() do.
  explicit Simulation(Model model, SimulationOptions options = {});
  /// Several bodies in one model. Give Scene::contacts() so that they touch. Throws Error as merge_models() does too.
  explicit Simulation(std::vector<SimulationBody> bodies, SimulationOptions options = {});
  ~Simulation();
  Simulation(Simulation&& other) noexcept;
  Simulation& operator=(Simulation&& other) noexcept;

  const Model& model() const;
  Scene& scene();
  const Scene& scene() const;
  Solver& solver();  ///< what is done with it directly is not recorded and not kept in the history
  const Solver& solver() const;

  /// Moves the body through `seconds` in n equal steps, n = ceil(seconds / step_limit()), at least 1. 0 seconds: takes
  /// over the scene and moves nothing. The report is that of Solver::step(). Equal calls take equal steps.
  StepReport advance(double seconds);

  /// Steps of step_limit() until the body is at rest, or `max_steps` were taken. Uses the damping of the options; if
  /// they have none, uses for this call a rate near the critical one of the body's slowest vibration, which it
  /// estimates while it runs. The time of the state goes on with the steps.
  RestResult run_to_rest(int max_steps = 200'000);

  double step_limit() const;  ///< s: SimulationOptions::step times stable_step(); 1e-3 for a body without stiffness
  double time() const;        ///< s

  /// The present state with the velocities of its own time: State as the solver has it holds those of half a step
  /// before. Forces of tools and contacts are left out of the half step; imposed coordinates keep the mean velocity of
  /// the last step.
  State state() const;
  /// Starts from a state whose velocities are those of its own time. Throws Error as Solver::reset() does. While the
  /// scene has tools, the velocities are converted for steps of step_limit(), otherwise for those of the next call.
  void set_state(const State& state);

  double max_displacement() const;  ///< m, largest distance of a particle from its rest position
  Energy energy() const;            ///< as Solver::energy()
  const ToolForce& force_on(const ToolHandle& tool) const;  ///< what the body does to the tool
  const ToolPose& pose_of(const ToolHandle& tool) const;    ///< where the tool is now

  /// All that further steps depend on, but for the scene, and back to it: in memory, or as a file. Throw Error as
  /// Solver::restore(), save_state() and load_state() do.
  Snapshot snapshot() const;
  void restore(const Snapshot& snapshot);
  void save(const std::string& path) const;
  void load(const std::string& path);

  /// From now on keeps a snapshot every `every` steps, in at most `most_bytes`; the oldest ones make room. Throws Error
  /// unless both are 1 or more.
  void keep_history(int every, std::size_t most_bytes = 64 << 20);
  /// Back to the newest snapshot of the history at or before `time`. False, and nothing done, if there is none.
  bool rewind(double time);

  /// Records from now on what is done through this object: advance(), run_to_rest(), set_state(), restore(), load(),
  /// rewind() and changes of the scene. Memory grows with it. Poses and grasps of tools that no step has seen yet are
  /// forgotten.
  void record();
  const Recording& recording() const;  ///< throws Error unless record() was called
  /// Clears the scene and does all of a recording again; see Replay. Ends a recording of one's own.
  void replay(Recording recording);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace phymul
