// SPDX-License-Identifier: MIT
//
// Simulation: one object that owns a model, its scene and its solver.
#pragma once

#include <phymul/body.h>
#include <phymul/recording.h>
#include <phymul/scene.h>
#include <phymul/solver.h>
#include <phymul/state_file.h>
#include <phymul/statics.h>
#include <phymul/topology.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace phymul {

struct GroupMaterial {
  std::string group;  ///< set_material(model, material, group) finds the cells
  Material material{};
};

/// Makes the solver of a Simulation instead of make_solver(), for an application's own backend (backend.h). Not null.
using SolverFactory = std::function<std::unique_ptr<Solver>(std::shared_ptr<const TopologyTextures> topology,
                                                            const Scene& scene, const SolverOptions& options)>;

struct SimulationOptions {
  Material material{};                     ///< of all cells; left out: the model keeps its materials
  std::vector<GroupMaterial> materials{};  ///< of groups, set after `material` in this order
  std::string backend = "auto";            ///< a name that make_solver() accepts
  Damping damping{};                       ///< replaces solver.damping, unless it is left out
  /// Largest step of advance() and run_to_rest(), as a multiple of Solver::stable_step(), > 0. Empty: it follows the
  /// deformation, between 0.25 (stiffening: less) and 0.9, in calls of many steps at most 0.5
  /// (Solver::suggested_step()).
  std::optional<double> step{};
  /// Cells that blades cut at most in a call of advance(), step() or run_to_rest(), >= 0; 0: all. Those that they have
  /// passed besides get their cuts, where they were passed, in the next calls, in order (StepReport::cut_later).
  int tick_budget = 0;
  std::shared_ptr<TaskRunner> runner{};  ///< replaces those of topology and solver, unless it is left out
  TopologyOptions topology{};
  SolverOptions solver{};
  SolverFactory make_solver{};                    ///< empty: phymul::make_solver() makes the solver
  std::function<void(const std::string&)> log{};  ///< receives each of Simulation::warnings() once; must not throw
};

/// One of several bodies of a Simulation. Its groups are named "<name>/<group>", as by merge_models().
struct SimulationBody {
  std::string name;
  Model model;
  Material material{};  ///< left out: SimulationOptions::material
};

/// Owns a model, its scene and its solver. It can be moved, not copied; references to the three and tool handles stay
/// valid when it is moved. Threads: as for Solver.
///
/// The first function that needs the solver makes it: fill the scene before, because the choice of "auto" depends on
/// it. These functions throw Error if the solver cannot be made. Otherwise advance() and run_to_rest() report failures
/// in their results and throw only what Solver::step() throws. solve_static() throws for what it does not support.
class Simulation {
 public:
  /// Sets the materials and builds the tables. Throws Error as set_material(), Scene and build_topology() do, and for
  /// an option out of its range.
  explicit Simulation(Model model, SimulationOptions options = {});
  /// Several bodies in one model. They touch each other if Scene::contacts({}) is called. Throws Error also as
  /// merge_models() does.
  explicit Simulation(std::vector<SimulationBody> bodies, SimulationOptions options = {});
  ~Simulation();
  Simulation(Simulation&& other) noexcept;
  Simulation& operator=(Simulation&& other) noexcept;

  const Model& model() const;
  Scene& scene();
  const Scene& scene() const;
  const Solver& solver() const;
  Solver& unrecorded_solver();  ///< for calls that record() and keep_history() must not see, and Solver::request_read()

  /// Simulates `seconds` in n = ceil(seconds / step_limit(seconds)) equal steps. 0 seconds: only applies changes of the
  /// scene. Returns the report of Solver::step().
  StepReport advance(double seconds);

  /// Simulates n steps of dt seconds, as Solver::step(); recorded and kept in the history as those of advance().
  StepReport step(int n, double dt);

  /// Takes steps of step_limit() until the body is at rest, at most `max_steps`. Uses the damping of the options. If
  /// they have none, the call chooses a damping near the critical one of the slowest vibration, which it estimates from
  /// the motion. The state's time advances as in every step.
  RestResult run_to_rest(int max_steps = 200'000);

  /// Removes cells (rows of Model::cells) of a body with materials, at a cost that follows their number: what is left
  /// is the body that build_topology() would make of the other cells, but for rounding, and keeps its motion. Numbers
  /// of particles and cells stay. A particle loses mass in proportion to its cells, save what it needs so as not to
  /// vibrate faster than the body did (at most its own); one without a cell has none and goes to its rest place, where
  /// nothing touches it. Surfaces, contacts, loads on surfaces, tools and joints follow: springs that end at a particle
  /// without a cell are broken, and a kept volume whose surface has lost a cell is no longer kept. Skins and what was
  /// asked for before (surface_triangles) do not follow. restore() and rewind() bring cells back. Looks at the whole
  /// body once, at the first call. Throws Error, and removes nothing, for a row out of range or of a cell without
  /// material, if nothing of the body would be left, and (not_supported) for a body without cells or material, where
  /// parts have local steps (SolverOptions::max_substeps above 1), and for backends that are not phymul's.
  void remove_cells(std::span<const Index> cells);
  const std::vector<Index>& removed_cells() const;  ///< ascending

  /// Cuts the body along a surface in its rest shape, as cut_body() does; what is left keeps its motion. Copies are
  /// made of the model's spare particles (with_spare_particles), so that numbers of particles stay; cells that part get
  /// a second row after all others. Groups get the copies of particles through which the cut passes; what is imposed on
  /// a particle is on all of its copies. Forces, joints, needles and tools stay at the particle of the same number,
  /// which is on its own side. What else depends on the body follows as in remove_cells(); restore() and rewind() undo
  /// cuts and make them again. Returns whether anything was cut. Throws Error, and cuts nothing, as cut_body() and
  /// remove_cells() do, and (not_supported) where the spare particles do not suffice.
  bool cut(const CutSurface& surface);
  const BodyCuts& cuts() const;  ///< those that the body has, in order

  /// Finds the rest shape under the loads of the present time, without steps: Newton's method on the energy, whose
  /// linear systems are solved by conjugate gradients with multigrid (docs/theory/physics.md). At small loads the
  /// number of evaluations does not grow with the body. Begins at the present state or at the rest shape, whichever has
  /// less energy; at the present state, if imposed coordinates are nearer their targets there. If it converges, the
  /// solver is in the rest state without motion, at the same time; otherwise it keeps its state. The status is failed
  /// if the loads drive a body that nothing holds, or if a spring of a joint would break.
  /// Tools are at their target poses; what they hold moves with them. The body should not enter a tool deeper than half
  /// the tool's thickness, or the tool pushes it out on the far side: then move the tool in several parts.
  /// Throws Error (not_supported) if the body or a particle of it has no material, or the body has two dimensions; for
  /// needles and tools with friction, a velocity, both ToolContact::surface and compliance, or a grasp or release still
  /// to come; for contacts and volume constraints; for walls beside cells, or with tools or joints; and for loads with
  /// events after the present time. Throws Error (invalid_argument) for options out of their range.
  /// Walls are solved by Newton's method with a factored tangent: an evaluation of it takes as long as some hundred
  /// of forces.
  StaticResult solve_static(const StaticOptions& options = {});

  /// Probable mistakes, one sentence each: a body without a material, sizes and constants that suggest other units than
  /// SI, a part that nothing holds (without tools and contacts, which may), cells too long for their thickness, a tool
  /// that is too thin, a tool that begins inside a body, a blade or a law of tearing without spare particles, bodies
  /// with contacts that begin inside each other (deeper than a quarter of an edge: this and every step throw Error).
  /// They refer to the model, and to the scene when the solver was made; tools that touch the particles of a body with
  /// cuts are named after a cut as well. Makes the solver.
  const std::vector<std::string>& warnings() const;

  /// Largest step that advance(seconds) would take now, s: SimulationOptions::step * Solver::stable_step(), or
  /// Solver::suggested_step(seconds); 1e-3 if that is infinite.
  double step_limit(double seconds = 0.0) const;
  double time() const;  ///< s, of the present state

  /// The present state with velocities at State::time. (Solver::read() returns those half a step earlier.) They are
  /// accurate to second order in the step for elastic forces and loads. What tools, contacts and volume constraints do
  /// is that of a next step in which the tools go on as in the last one; a backend that is no SolverBackend has them
  /// stand still. Velocities of imposed coordinates are their means over the last step.
  State state() const;
  /// Starts from a state with velocities at State::time. Cells that wait for their cuts (tick_budget) stay in line.
  /// Throws Error as Solver::start() does.
  void set_state(const State& state);

  double max_displacement() const;  ///< m, largest distance of a particle from its rest position
  Energy energy() const;            ///< as Solver::energy()
  /// Force of the particles on the tool in the last step, or in the rest shape after solve_static(). References and
  /// errors: as Solver::tool_force().
  const ToolForce& force_on(const ToolHandle& tool) const;
  const ToolPose& pose_of(const ToolHandle& tool) const;  ///< present pose of the tool
  /// Of the last step, as Solver::joint_report(), or of the rest shape after solve_static().
  const JointReport& report_of(const JointHandle& joint) const;

  /// The state with everything that further steps depend on (Snapshot), in memory or in a file. restore(), load() and
  /// rewind() also bring back the scene's tools, joints and threads: they remove those that were added since, add those
  /// that were removed, and undo the changes of a JointHandle or ThreadHandle (Scene::bring_back(), which says which
  /// handles stay valid). Loads, gravity, contacts, volume constraints and factors of stiffness stay as they are. To
  /// start from positions alone, with what the scene has, call set_state(). A snapshot does not have clamps of threads
  /// and volumes that no step has applied yet. They throw Error as Solver::restore(), save_state() and load_state() do.
  Snapshot snapshot() const;
  void restore(const Snapshot& snapshot);
  void save(const std::string& path) const;
  void load(const std::string& path);

  /// Keeps a snapshot every `every` steps from now on, at most `most_bytes` in all; the oldest are dropped. Applies
  /// changes of the scene. Throws Error unless both are at least 1.
  void keep_history(int every, std::size_t most_bytes = 64 << 20);
  /// Goes back to the newest kept snapshot at or before `time`, s, as restore() does (StateHistory::newest_at). Returns
  /// false, and changes nothing, if there is none.
  bool rewind(double time);

  /// Records steps, changes of the state and changes of the scene from now on. Memory grows with their number. Discards
  /// tool poses, grasps, clamps of threads and volumes that no step has applied yet: repeat them after this call.
  void record();
  const Recording& recording() const;  ///< throws Error unless record() was called
  /// Clears the scene and repeats a recording to its end. Throws Error as Replay does. Ends record(). What is refused
  /// at its start leaves all as it was, but that handles may be of tools, joints and threads that are gone.
  void replay(Recording recording);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace phymul
