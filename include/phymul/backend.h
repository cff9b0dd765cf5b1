// SPDX-License-Identifier: MIT
//
// SolverBackend: base class of all backends. Only authors of backends need this header.
#pragma once

#include <phymul/elasticity.h>
#include <phymul/load_frame.h>
#include <phymul/solver.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

class JointSet;         // src/interaction/joint_set.h
class Profile;          // src/solver/profile.h
class MaterialSpectra;  // src/elastic/material_spectra.h
class ScaledTables;     // src/elastic/scaled_tables.h
class StiffJoints;      // src/interaction/stiff_joints.h
struct LocalSteps;      // src/elastic/local_steps.h

/// Implements what all backends have in common: checks of arguments and states, the step limit, failure policy, rest
/// test, progress calls, and the default of every optional function. A backend overrides the private functions do_*(),
/// at least do_reset, do_scene_changed, do_step, do_read, do_energy, do_time and do_device.
class SolverBackend : public Solver {
 public:
  ~SolverBackend() override;

  std::string_view name() const final { return name_; }
  std::string device() const final { return do_device(); }
  std::string_view backend_reason() const final { return backend_reason_; }
  const Scene& scene() const final { return *scene_; }
  const TopologyTextures& topology() const final { return *topology_; }
  std::uint64_t topology_hash() const final;
  const SolverOptions& options() const final { return options_; }
  bool takes_tools() const final { return do_takes_tools(); }
  double stable_step() const final { return step_limit(options_.damping); }
  double suggested_step(double seconds) const final;
  int substeps() const final;
  /// `further` and the change of the forces at a state, `further` included, by SolverOptions::max_substeps in a step of
  /// `dt` s. [N] N, or empty.
  VecList substep_forces(const State& state, double dt, VecList further = {}) const;
  /// Sets the velocities of tools that moved in the last step, of `dt` s, to those they had in it. `tools`: of read().
  void set_last_velocities(std::vector<ToolState>& tools, double dt) const;

  using Solver::read;
  using Solver::reset;
  using Solver::run_to_rest;
  void reset(const State& state) final;
  Snapshot snapshot() const final;
  void restore(const Snapshot& snapshot) final;
  void start(const State& state, double dt) final;
  StepReport step(int n, double dt) final;
  RestResult run_to_rest(int max_steps, double dt, const Damping& damping) final;
  double time() const final { return do_time(); }
  void read(State& state) const final;
  void request_read() final { do_request_read(); }
  bool collect(State& state) final { return do_collect(state); }
  Energy energy() const final { return do_energy(); }
  Momentum momentum(const Vec3& about = Vec3::Zero()) const final { return do_momentum(about); }
  ParticleBuffer position_buffer() const final { return do_position_buffer(); }
  ParticleBuffer attractor_buffer() const final;
  std::vector<PassProfile> profile() const final;
  void body_changed() final;
  void clear_profile() final;

 protected:
  /// Throws Error for options out of their range and for tables of another model than the scene's. The constructor of a
  /// backend must end with reset(), or with begin_at_rest() if its own arrays have the rest shape without velocities.
  SolverBackend(std::string name, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                const SolverOptions& options);

  void begin_at_rest();  ///< what reset() does besides do_reset(), without a copy of the rest shape

  /// Result of do_step(). Maxima are of the last good step and of free coordinates only.
  struct Motion {
    int steps = 0;                  ///< number of good steps
    Index bad_particle = -1;        ///< >= 0: this particle diverged in the next step, which was undone
    bool lost = false;              ///< the device failed
    int lost_volume = -1;           ///< >= 0: row of Scene::volume_constraints() that the next step violates
    const char* not_finite = "";    ///< why the next step was undone, if neither of these; static text
    bool force_clamped = false;     ///< some elastic acceleration was above StepPlan::largest_acceleration
    double max_acceleration = 0.0;  ///< m/s^2
    double max_force = 0.0;         ///< N
    double max_speed = 0.0;         ///< m/s
    double max_displacement = 0.0;  ///< m, of all particles, from their rest places; 0: not computed
    /// strain_summary() (elasticity.h) of the last step; a growth of 0: not known of this call, infinite: this backend
    /// does not compute it.
    StrainSummary strain{};
    int steps_at_rest = 0;  ///< number of consecutive steps up to the last one within the thresholds
  };
  /// Argument of do_step().
  struct StepPlan {
    int steps = 0;
    double dt = 0.0;                    ///< s
    double damping_factor = 1.0;        ///< Damping::factor_at(dt)
    double speed_at_rest = 0.0;         ///< m/s, threshold of the rest test
    double acceleration_at_rest = 0.0;  ///< m/s^2, threshold of the rest test
    double omega_max = 0.0;             ///< rad/s, upper bound for the body and the scene's joints
    double largest_acceleration = 0.0;  ///< m/s^2: elastic force over mass is limited to this; may be infinite
    double runaway_speed = 0.0;         ///< m/s: a faster particle, or one that is not finite, has diverged
    bool stop_at_rest = false;          ///< end as soon as steps_at_rest reaches rest_steps
    int rest_steps = 0;
  };

  /// Throws Error if the snapshot has parts; for backends that have none.
  void refuse_parts(const Snapshot& snapshot) const;

  /// Energy of a state, with the present scene, in double precision. State::velocity is that of half a step before.
  /// last_dt: s, of the step that led to the state, or 0. dissipative: [N] N, forces without an energy, or empty.
  Energy energy_of(const State& state, double last_dt, const VecList& dissipative = {}) const;

  /// topology(), scaled by Scene::stiffness_factors(); valid until these change. Allocates at the first other than 1.
  const TopologyTextures& elastic() const;
  /// Of an edited body: particles without mass at rest at their places, held by no tool.
  State without_removed(State state) const;
  const LocalSteps* local_steps() const { return local_steps_.get(); }  ///< null: one step for all
  /// Why only "cpu" and "reference" support this body (its substeps), as a result for do_cannot(); null: others may.
  const char* beyond_devices() const;

  /// For the constructor of a backend that solves stiff_joints() in each step; others leave them explicit.
  void solve_stiff_joints();
  StiffJoints* stiff_joints() { return stiff_joints_.get(); }  ///< null: all joints are explicit

  LoadFrame& frame() { return frame_; }              ///< prepared; a backend evaluates it at the time of each step
  const LoadFrame& frame() const { return frame_; }  ///< of the scene as the last step or reset saw it
  JointSet& joints() { return *joints_; }            ///< of the scene; empty for backends without joints
  const JointSet& joints() const { return *joints_; }
  Profile* profiling() const { return profile_.get(); }  ///< null unless SolverOptions::profile

 private:
  virtual void do_reset(const State& state) = 0;
  virtual void do_scene_changed() = 0;  ///< frame() may have other sizes than before; may allocate
  /// Only values have changed: Scene::mode_values() of the same modes, constants of joints, or stiffness_factors().
  /// Must not allocate. Must set the count of steps at rest to 0.
  virtual void do_values_changed() { do_scene_changed(); }
  /// The tables of these domains changed, and the masses of their particles; do_scene_changed() comes next. The default
  /// throws Error.
  virtual void do_body_changed(std::span<const Index> domains);
  Snapshot snapshot_without_hash() const;
  void continue_copies(std::span<const Index> domains);
  virtual Motion do_step(const StepPlan& plan) = 0;
  virtual void do_read(State& state) const = 0;
  virtual Energy do_energy() const = 0;
  virtual double do_time() const = 0;
  /// Adds seconds to the state's time without a step. False: the backend cannot, and such a call is stepped.
  virtual bool do_pass_time(double) { return false; }
  virtual std::string do_device() const = 0;
  // Optional: access without waiting or without a copy. The defaults use read().
  virtual void do_request_read();
  virtual bool do_collect(State& state);
  virtual Momentum do_momentum(const Vec3& about) const;
  virtual ParticleBuffer do_position_buffer() const;
  virtual ParticleBuffer do_attractor_buffer() const;
  // Optional: for backends whose state has more data than a State, or higher precision.
  virtual void do_snapshot(Snapshot& snapshot) const;
  virtual void do_restore(const Snapshot& snapshot);
  /// Which part of the scene or body this backend does not support, one sentence of static text; null: none. The
  /// default names needles, ToolContact::surface, threads, substeps, joints, materials that dissipate, stiffness
  /// factors and contacts; and tools and volume constraints unless the two functions below return true.
  virtual const char* do_cannot() const;
  virtual bool do_takes_tools() const { return false; }
  virtual bool do_takes_volumes() const { return false; }             ///< Scene::constrain_volume
  virtual const ToolReport& do_tool_report(std::size_t row) const;    ///< of Scene::tools(), as of the last step
  virtual const ThreadState& do_thread_state(std::size_t row) const;  ///< of Scene::threads(), likewise
  virtual const FluidState& do_fluid(std::size_t row) const;          ///< of Scene::volume_constraints()
  virtual void do_profile() const {}                                  ///< updates profiling(), which is not null

  friend std::unique_ptr<Solver> make_solver(std::string_view, std::shared_ptr<const TopologyTextures>, const Scene&,
                                             const SolverOptions&);
  const ToolReport& tool_report(std::size_t row) const final;
  void bring_back_reports(const Snapshot& snapshot);
  const JointReport& joint_report_at(std::size_t row) const final;
  const ThreadState& thread_state_at(std::size_t row) const final { return do_thread_state(row); }
  const FluidState& fluid_at(std::size_t row) const final { return do_fluid(row); }
  double step_limit(const Damping& damping) const;  // s
  double stiffness_factor() const;                  // by which the scene's raise the spectrum at most
  Spectrum spectrum() const;                        // a bound, of materials as stiff as the scene makes them
  void require_fitting(const State& state) const;
  void require_supported() const;
  void require_idle(const char* what) const;
  void follow_scene();
  void follow_joints();
  void take_spectrum();
  double energy_of_larger_masses(const State& state, const VecList& next, double dt,
                                 const std::vector<std::uint8_t>& fixed) const;
  bool any_tool_grasps() const;
  StepReport advance(int n, double dt, bool stop_at_rest, const Damping& damping);
  StepReport still(const StepReport& call) const;
  StepPlan plan_for(int n, double dt, const Damping& damping, bool beyond_limit) const;
  int tissue_gave_way() const;  // ToolReport::tissue_gave_way of all tools
  void note_strain(const Motion& motion, StepReport& report);
  void report_failure(const Motion& motion, StepReport& report) const;
  Motion run(const StepPlan& plan, StepReport& report);
  Motion run_with_progress(const StepPlan& plan, StepReport& report);

  std::string name_, backend_reason_;
  std::atomic_flag is_stepping_;
  std::vector<State> copies_;          // of the default do_request_read()
  mutable VecList shown_, attracted_;  // of the default buffers
  std::shared_ptr<const TopologyTextures> topology_;
  const Scene* scene_;
  SolverOptions options_;
  LoadFrame frame_;
  std::uint64_t scene_version_ = 0, values_version_ = 0;
  std::optional<Index> loose_;         // RestResult's, of the scene of these versions; empty: not yet looked for
  double growth_ = 0.0, speed_ = 0.0;  // Snapshot's
  struct LastStep {
    double dt = 0.0;      // s; 0: there was none
    double passed = 0.0;  // s, since then without a step
    StepReport report{};
  } last_{};
  Index first_beyond_ = -1;               // StepReport's
  double beyond_since_ = 0.0;             // s
  std::optional<bool> all_held_;          // of the scene of these versions; empty: not yet looked for
  mutable double growth_of_state_ = 0.0;  // where growth_ is 0; 0: not yet computed
  mutable std::optional<std::uint64_t> topology_hash_;
  // Of the restored snapshot, until a step is done or reset() called; by SceneTool::id and SceneJoint::id.
  std::map<std::uint64_t, ToolReport> tools_before_;
  std::map<std::uint64_t, JointReport> joints_before_;
  std::unique_ptr<Profile> profile_;
  std::unique_ptr<JointSet> joints_;
  std::unique_ptr<StiffJoints> stiff_joints_;
  int steps_a_slice_ = 1;                             // between two looks at the clock, if progress is asked for
  Spectrum own_spectrum_;                             // of the model's own stiffness
  std::size_t edits_seen_ = 0;                        // TopologyTextures::edits
  std::size_t domains_seen_ = 0;                      // of TopologyTextures::edited
  std::size_t copies_seen_ = 0, exchanged_seen_ = 0;  // of TopologyTextures::copied, exchanged
  double largest_before_edits_ = 0.0;                 // own_spectrum_.largest
  double stiffness_ = 0.0, viscosity_ = 0.0;  // bounds of it and of its dissipation, over the masses: 1/s^2, 1/s
  std::unique_ptr<ScaledTables> scaled_;
  std::unique_ptr<const LocalSteps> local_steps_;
  mutable std::unique_ptr<MaterialSpectra> materials_;  // null before the first factors
  double spacing_ = 0.0;
};

}  // namespace phymul
