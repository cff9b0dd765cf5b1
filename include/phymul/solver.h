// SPDX-License-Identifier: MIT
//
// Solver: moves a body through time. One abstract class; make_solver makes one by the name of a backend.
#pragma once

#include <phymul/scene.h>
#include <phymul/solver_options.h>
#include <phymul/state.h>
#include <phymul/step_report.h>
#include <phymul/topology_textures.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

/// Time that one part of the steps took: a kind of force, the integration, a shader.
struct PassProfile {
  std::string name;
  std::int64_t runs = 0;  ///< CPU backends: one per step. GL: one per draw; steps that were undone count too
  double seconds = 0.0;   ///< s of the calling thread. GL: for submitting the pass, without its work
  /// s by the device's timers. NaN if the device has none (llvmpipe for compute shaders) or they were disturbed, for
  /// example by a change of the clock rate.
  double device_seconds = std::numeric_limits<double>::quiet_NaN();
};

struct Energy {
  double elastic = 0.0;  ///< J, including that of Material::relaxation_strength and of joints
  /// J: 1/2 sum m v- . v+ with the velocities half a step before and after `time`. With it the total of an undamped
  /// linear body is constant in Verlet's scheme for every step size.
  double kinetic = 0.0;
  double gravity = 0.0;  ///< J, of the scene's gravity; 0 in the rest shape
  double total() const { return elastic + kinetic + gravity; }
};

struct Momentum {
  Vec3 linear{0, 0, 0};   ///< kg m/s
  Vec3 angular{0, 0, 0};  ///< kg m^2/s, about the point passed
};

/// One vector per particle in the backend's memory, to be drawn without a copy: either in `texture` or in `position`.
struct ParticleBuffer {
  /// GL backends: name of an RGBA32F texture in the solver's share group. Texel (i mod width, i / width) holds in xyz
  /// the displacement of particle i from its rest position, m; w has no meaning. 0: no texture.
  std::uint32_t texture = 0;
  int width = 0, height = 0;
  std::span<const Vec3> position;  ///< CPU backends: [N] m
};

/// The state of a body and the functions that change it.
///
/// Lifetimes: a solver keeps a pointer to its scene and, through it, to the model. Both must outlive the solver and
/// stay at their address, and the model must not change. Simulation (simulation.h) owns all three and has no such rule.
/// Threads: one thread at a time may call a solver, const functions included, and no other thread may then use its
/// scene. Two solvers are independent, even if they share tables or a scene that nobody changes.
/// Exceptions and memory: step() throws only std::bad_alloc, what SolverOptions::progress throws, and Error where a
/// backend cannot take over what the scene has changed to, as surfaces too far apart on gl-compute. It allocates in
/// the first step after a change of the scene, when more surfaces are near each other than ever before, where a needle,
/// a blade or a tear advances, and where a thread lies on something. Scene::set_events and new tool poses are not
/// such changes. "reference" also allocates at its first force and at its first imposed position. Only read() and
/// functions whose comment says so wait for a device.
class Solver {
 public:
  virtual ~Solver();
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  virtual std::string_view name() const = 0;            ///< name of the backend
  virtual std::string device() const = 0;               ///< renderer or processor, for people and result files
  virtual std::string_view backend_reason() const = 0;  ///< why "auto" chose this backend; empty if it was named
  virtual const Scene& scene() const = 0;
  const Model& model() const { return scene().model(); }
  virtual const TopologyTextures& topology() const = 0;
  /// fingerprint() of the tables (topology_textures.h). The first call of this function, snapshot() or restore()
  /// computes it.
  virtual std::uint64_t topology_hash() const = 0;
  virtual const SolverOptions& options() const = 0;
  virtual bool takes_tools() const = 0;  ///< false: make_solver and step() refuse scenes with tools

  /// Largest stable dt, s, of the free body at rest, with the solver's damping, rate and factor, and the scene's
  /// joints. Fixed particles can only raise it. Deformation may lower it: use suggested_step() or half of it. Infinite
  /// for a body without stiffness and joints, for which every finite dt is stable. See estimate_spectrum
  /// (elasticity.h); joints: docs/guide/joints.md.
  virtual double stable_step() const = 0;
  /// A step for motion that goes on for `seconds`, s: 0.9 times the stable step of the present state, and between 0.25
  /// (less for Material::stiffening) and 0.9 of stable_step(). By a bound on how much deformation has raised the
  /// highest frequency (StepReport::growth), and on how much it may while the fastest particle, or a tool on its way to
  /// its target pose, moves on for `seconds`. At most 0.5 if these are more than 16 steps; 0.5 where nothing is known:
  /// with substeps, on the backends gl and gl-compute, for bodies without a material. After reset() it reads the state.
  /// Depends on nothing that a Snapshot lacks, but for the scene.
  virtual double suggested_step(double seconds) const = 0;
  /// Substeps per step of the materials that need a shorter step (SolverOptions::max_substeps). 1: no material does.
  virtual int substeps() const = 0;

  /// Starts from a state. Throws Error, and changes nothing, if the state's sizes do not fit, a value is not finite, z
  /// is not 0 in a two-dimensional model, or State::tools has a particle held twice, particles held by a needle or a
  /// blade, or a hole of another shape.
  /// Also throws Error if the backend does not support the scene, and during step().
  ///
  /// After reset(), restore(), start() and StateHistory::rewind() each tool holds the particles listed in the state,
  /// until the next ToolHandle::grasp() or release(). Earlier calls of grasp() and release() have no effect. A
  /// move_to() or grasp() made before the solver existed takes effect in the solver's first step, unless one of the
  /// four functions is called before this step.
  virtual void reset(const State& state) = 0;
  void reset();  ///< to the rest shape; no tool holds anything

  /// The state with everything that further steps depend on (Snapshot); restore() sets it. Afterwards forces of tools
  /// and reports of joints are those of the step before the snapshot. restore() throws Error, and changes nothing, as
  /// reset() does, if the snapshot is of another body (Snapshot::topology_hash), if it has parts that this backend does
  /// not know, and if the scene has other tools or joints: then call Scene::bring_back(*snapshot.scene) before, as
  /// Simulation::restore() does, or clear Snapshot::scene to keep those of the scene. Every backend accepts
  /// reset(snapshot.state).
  virtual Snapshot snapshot() const = 0;
  virtual void restore(const Snapshot& snapshot) = 0;
  /// As reset(), but the state's velocities are those at State::time; reset() expects those half a step earlier
  /// (State::velocity). `dt`: s, of the following steps. Throws Error also unless dt is finite and above 0.
  virtual void start(const State& state, double dt) = 0;

  /// Does n steps of dt seconds; dt must be finite and at least 1e-18 s. Applies changes of the scene first. After a
  /// failure the last good state is kept. n = 0 only applies the changes; the report's residual, max_speed and at_rest
  /// then have no meaning. Calls that together last less than 1e-6 of the step before pass time alone, with no step and
  /// the report of that one: what rounding leaves at the end of calls whose times add up to one. What was asked of
  /// tools waits. StepStatus::invalid_step for other arguments or while another call of it or run_to_rest() runs.
  virtual StepReport step(int n, double dt) = 0;

  /// Steps until the body is at rest (SolverOptions::rest_tolerance), at most max_steps. Does not wait for load events
  /// in the future: call step() up to the last one first. Needs SolverOptions::damping, even if the material
  /// dissipates; without it the call does nothing and its report says invalid_step.
  RestResult run_to_rest(int max_steps, double dt);
  /// The same with this damping instead of that of the options.
  virtual RestResult run_to_rest(int max_steps, double dt, const Damping& damping) = 0;

  virtual double time() const = 0;            ///< s, of the present state
  virtual void read(State& state) const = 0;  ///< copies the state
  State read() const;

  /// Starts a copy of the present state without waiting for the device. At most three copies are pending; a fourth
  /// request replaces the third.
  virtual void request_read() = 0;
  /// Moves the oldest requested copy to `state` if it is complete. Returns false, without waiting, if it is not or none
  /// was requested. reset() and restore() drop pending copies.
  virtual bool collect(State& state) = 0;

  virtual Energy energy() const = 0;  ///< of the present state and scene; allocates
  /// Momentum of the present state, from State::velocity. `about`: m, point for the angular momentum.
  virtual Momentum momentum(const Vec3& about = Vec3::Zero()) const = 0;

  /// Positions, or attractors P* (topology.h), without a copy. Valid until the next step(), reset() or restore(), while
  /// the solver exists. GL backends wait for the device; bind the texture in a context of the share group.
  virtual ParticleBuffer position_buffer() const = 0;
  virtual ParticleBuffer attractor_buffer() const = 0;  ///< empty if the law has no attractors

  /// Follows an edit of the tables (TopologyTextures::edited) and of the scene's model, after Scene::body_changed().
  /// The state stays; particles without mass go to their rest places. Throws Error for a backend that cannot.
  virtual void body_changed() = 0;

  /// Times since the solver was made or clear_profile() was called, in the order of first use. Empty unless
  /// SolverOptions::profile is set. GL backends wait for the device.
  virtual std::vector<PassProfile> profile() const = 0;
  virtual void clear_profile() = 0;

  /// Force of the particles on a tool of the scene, and the tool's present pose. Before the first step, and after
  /// reset(): zero, and the scene's pose or the state's. References are valid until the next step() or change of the
  /// scene. The functions throw Error for an unknown name, do not allocate and never wait for a device.
  const ToolForce& tool_force(std::string_view name) const;
  const ToolPose& tool_pose(std::string_view name) const;
  /// The same without a search for the name. They throw Error if the tool is of another scene or was removed.
  const ToolForce& tool_force(const ToolHandle& tool) const;
  const ToolPose& tool_pose(const ToolHandle& tool) const;
  /// Number of particles that a tool holds now. grasp() and release() take effect in the next step. Errors as above.
  int held(std::string_view name) const;
  int held(const ToolHandle& tool) const;
  /// Whether a grasp() or release() waits for the next step. Errors as above.
  bool has_grasp_ahead(std::string_view name) const;
  /// [count] points along a needle, evenly spaced from tip to hub, m. Error if it is not a needle or count is below 2.
  VecList needle_points(std::string_view name, int count) const;

  /// Forces, lengths and broken springs of a joint of the scene. Valid until the next step() or change of the scene.
  /// They throw Error for an unknown name, a handle of another scene, and a joint that was removed.
  const JointReport& joint_report(std::string_view name) const;
  const JointReport& joint_report(const JointHandle& joint) const;

  /// A thread of the scene after the last step. Valid until the next step() or change of the scene. Errors as above.
  const ThreadState& thread_state(std::string_view name) const;
  const ThreadState& thread_state(const ThreadHandle& thread) const;

  /// The fluid of a volume constraint of the scene after the last step. Valid until the next step() or change of the
  /// scene. Throws Error for an unknown name, and for backends that do not know it (gl, gl-compute).
  const FluidState& fluid(std::string_view name) const;

 protected:
  Solver();

 private:
  virtual const ToolReport& tool_report(std::size_t row) const = 0;       ///< of Scene::tools()
  virtual const JointReport& joint_report_at(std::size_t row) const = 0;  ///< of Scene::joints()
  virtual const ThreadState& thread_state_at(std::size_t row) const = 0;  ///< of Scene::threads()
  virtual const FluidState& fluid_at(std::size_t row) const = 0;          ///< of Scene::volume_constraints()
  std::size_t tool_row(std::string_view name) const;
  std::size_t tool_row(const ToolHandle& tool) const;
};

/// Makes a solver at the rest shape. "auto" chooses "cpu"; or "gl-compute" ("gl" without compute shaders) if a GPU was
/// measured to be faster on this body; or "reference" if single precision cannot represent the body. Throws Error for
/// an unknown name, with the known ones, for a backend that this build or machine does not have, and if the scene was
/// not made for this `model` object.
std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene& scene,
                                    const TopologyOptions& topology = {}, const SolverOptions& options = {});
std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene&& scene,
                                    const TopologyOptions& topology = {},
                                    const SolverOptions& options = {}) = delete;  ///< the scene must outlive it

/// The same with tables of build_topology(), which any number of solvers may share. Throws Error, with the difference,
/// if the scene's model differs in anything that build_topology() reads. It may be a copy of the model of the tables.
std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene& scene, const SolverOptions& options = {});
std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene&& scene, const SolverOptions& options = {}) = delete;

/// Names that make_solver accepts in this build, without "auto".
std::vector<std::string> backend_names();

/// Why this machine cannot run a backend: a missing library, or a driver without a context. Empty if it can, and for
/// "auto". Throws Error for an unknown name.
std::string why_unavailable(std::string_view backend, const SolverOptions& options = {});

}  // namespace phymul
