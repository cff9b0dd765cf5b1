// SPDX-License-Identifier: MIT
//
// Solver: moves a body through time. One abstract class, backends by name.
#pragma once

#include <phymul/elasticity.h>
#include <phymul/gl.h>
#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

/// Loss of velocity. A rate gives the same result whatever the step; the raw factor is the thesis' d. It is drag on
/// motion relative to the world, not to the body: under gravity g a free body at a rate falls at no more than g / rate.
struct Damping {
  double rate = 0.0;                  ///< 1/s, >= 0: velocity is multiplied by exp(-rate dt) each step
  double factor = 1.0;                ///< raw d per step in [0, 1], on top of the rate; 1 takes nothing
  double factor_at(double dt) const;  ///< both together, for a step of dt
  bool operator==(const Damping&) const = default;
};

enum class UnstableStep {
  refuse,  ///< step() does nothing and says unstable_step
  allow    ///< step() goes on; the report says so
};

/// How far a call has come: SolverOptions::progress.
struct StepProgress {
  int steps = 0;           ///< done by this call
  int of = 0;              ///< asked for; of run_to_rest() the most there will be
  double time = 0.0;       ///< s, of the state reached
  double residual = 0.0;   ///< N, as StepReport has it
  double max_speed = 0.0;  ///< m/s
};

struct SolverOptions {
  Damping damping;
  UnstableStep on_unstable = UnstableStep::refuse;
  /// A body rests when, for `rest_steps` steps on end, no free particle's speed times tau exceeds rest_tolerance * h
  /// and no net force over mass times tau^2 does; h is the mean spacing, tau = 1 / omega_max. Independent of dt and
  /// scale. In single precision ("cpu", GL) the first bound is at least 8 x 2^-24 of the body's largest displacement
  /// over tau, the second as much over tau^2: rounding alone shakes a body that rests displaced so far (DESIGN.md).
  double rest_tolerance = 1e-8;
  int rest_steps = 16;
  /// In mean spacings: an elastic force that by itself would move its particle further than this in one step is
  /// limited to that distance, and StepReport::force_clamped is set. Forces of this size occur only in states that real
  /// tissue does not reach (flattened, mirrored, scattered). There an explicit step overshoots; with the limit bodies
  /// return from such states at half the step limit. Momentum and energy are not conserved while the limit acts. It is
  /// off for steps beyond the step limit and for models that are unstable at rest or flutter, whose growth it would
  /// hide. Infinite: always off.
  double max_displacement_per_step = 0.1;
  /// Of these very tables at rest, where it is known: saves estimating it, which takes a hundred force evaluations or
  /// so. A wrong one makes stable_step() and the rest test wrong.
  std::optional<Spectrum> spectrum;
  /// Of the backend "cpu": threads to run on. 0: as many as the body has work for, up to the processors. Results do not
  /// depend on it.
  int threads = 0;
  /// step() and run_to_rest() call it between two steps, not before `progress_seconds` have passed since they began or
  /// called it last, and never after their last step. False ends the call there: StepReport::stopped. What it throws
  /// leaves the call; the state is that after the steps it was told of. It may read the solver, not step, reset or
  /// change its scene. No trajectory depends on it; with tools in the scene, whose way is a call's, it is not called.
  std::function<bool(const StepProgress&)> progress;
  double progress_seconds = 0.5;  ///< 0: after every step
  bool profile = false;           ///< Solver::profile() has something to say; off, no clock is asked
  GlOptions gl;                   ///< of the GL backends; the others do not look at it
};

/// not_finite: a particle would have left the finite numbers, or run faster than a million spacings times omega_max,
/// which no body survives; the step was not taken.
/// volume_lost: an enclosed volume (Scene::constrain_volume) could not be restored; the step was not taken.
/// not_supported: the scene has tools, volumes or contacts that this backend does not take; nothing was done.
/// needle_full: a needle's hole would be longer, or a point of it a mean of more particles, than a device has room for;
/// the step was not taken.
enum class StepStatus {
  ok,
  invalid_step,
  unstable_step,
  not_finite,
  device_lost,
  volume_lost,
  not_supported,
  needle_full
};

struct StepReport {
  StepStatus status = StepStatus::ok;
  int steps = 0;              ///< steps done by this call
  double time = 0.0;          ///< s, of the state reached (of the last good one after a failure)
  double dt = 0.0;            ///< s, as asked
  double stable_step = 0.0;   ///< s, limit at rest; see stable_step()
  bool beyond_limit = false;  ///< dt was above it and allowed
  bool to_rest = false;       ///< run_to_rest() made it
  bool at_rest = false;       ///< the rest test held at the end; ok() does not say so
  double residual = 0.0;      ///< largest net force on a free particle at the last step, N
  double max_speed = 0.0;     ///< largest speed, m/s
  /// An elastic force was limited in some step of this call: SolverOptions::max_displacement_per_step.
  bool force_clamped = false;
  bool stopped = false;  ///< SolverOptions::progress ended the call before its last step
  /// run_to_rest() that came to rest: a particle one of whose bases has collapsed to a line or a point, else -1. Such a
  /// base has no direction; a body all in one point is at rest so and cannot come back by itself.
  Index collapsed = -1;
  /// Likewise: a cell that rests turned inside out or flat, else -1. Springs keep such states. step() sets neither: in
  /// a body that moves, or after step(), ask first_folded_cell() (monitor.h) and first_collapsed() (elasticity.h).
  Index folded = -1;
  Index particle = -1;     ///< culprit of a failure, row of the model
  const char* cause = "";  ///< likely cause of a failure, static text

  /// No failure. A run_to_rest() that used up its steps is ok too: ask at_rest.
  bool ok() const { return status == StepStatus::ok; }
  /// A sentence for a person; "not at rest after ..." where run_to_rest() did not come to rest. Allocates.
  std::string message() const;
};

/// What one pass of the steps has cost: a kind of force, the move, a shader.
struct PassProfile {
  std::string name;
  std::int64_t runs = 0;  ///< CPU backends: one a step. GL: one a draw; steps tried and taken back count too
  /// s of the thread that works for the caller. GL: of handing the pass over, not of its work.
  double seconds = 0.0;
  /// s by the device's own timers; not a number where it has none (llvmpipe, of compute shaders), or where they were
  /// disturbed (a laptop that changed its clock), or the host was timing itself.
  double device_seconds = std::numeric_limits<double>::quiet_NaN();
};

class Profile;  // src/solver/profile.h

struct Energy {
  double elastic = 0.0;  ///< J
  /// J: 1/2 sum m v- . v+ with the velocities half a step before and after `time`. With it the total of an undamped
  /// linear body is constant in Verlet's scheme, whatever the step.
  double kinetic = 0.0;
  double gravity = 0.0;  ///< J, of the scene's gravity; 0 in the rest shape
  double total() const { return elastic + kinetic + gravity; }
};

struct Momentum {
  Vec3 linear{0, 0, 0};   ///< kg m/s
  Vec3 angular{0, 0, 0};  ///< kg m^2/s, about the point asked for
};

/// Where a backend keeps one vector per particle, to be drawn as it stands. One of the two members is filled.
struct ParticleBuffer {
  /// GL backends: name of an RGBA32F texture in the solver's share group; texel (i mod width, i / width) holds particle
  /// i's displacement from its rest place in xyz, m; w means nothing. 0: none.
  std::uint32_t texture = 0;
  int width = 0, height = 0;
  std::span<const Vec3> position;  ///< CPU backends: [N] m
};

/// step() throws nothing but std::bad_alloc and what SolverOptions::progress throws, and allocates only in the first
/// step after a change of the scene ("reference": after its first force or first imposed position; Scene::set_events
/// is none), and where more surfaces are near each other than ever before; read() is the one call that waits for a
/// device.
///
/// Threads: one at a time may call a solver, const functions too, and it must be the only one to touch the solver's
/// scene then. Two solvers are independent: each may have its thread, and they may share tables, and a scene that
/// nobody changes meanwhile.
/// Lifetimes: points to the scene and, through it, to the model. Both must outlive it, stay where they are in memory,
/// and the model must not change. Nothing can check this.
class Solver {
 public:
  virtual ~Solver();
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  std::string_view name() const { return name_; }
  const Model& model() const { return scene_->model(); }
  const TopologyTextures& topology() const { return *topology_; }
  /// fingerprint() of the tables (state_file.h): computed by the first call of it, or of snapshot() or restore().
  std::uint64_t topology_hash() const;
  const SolverOptions& options() const { return options_; }

  /// Starts from a state; throws Error when its sizes do not fit, a value is not finite, z is not 0 in a
  /// two-dimensional model, or a tool of the scene has in State::tools what its shape cannot have: a needle particles
  /// that it holds, another shape a hole (state untouched then; rename the tool, or take out its entry).
  ///
  /// After reset(), restore(), start() and StateHistory::rewind() a tool holds what the state says and nothing else,
  /// until ToolHandle::grasp() or release() is called after them: a call made before counts as done, whether a step
  /// has seen it or not. (What was asked for before the solver was made is done at its first step, if none of these
  /// comes first.)
  void reset(const State& state);
  void reset();  ///< the rest shape, no tool holding anything

  /// The state with all that further steps depend on, and back to it. restore() throws as reset() does, where the
  /// snapshot is of another body (Snapshot::topology_hash; for its positions alone: reset(snapshot.state)), and where
  /// it has parts that this solver does not know; the solver is then as it was.
  Snapshot snapshot() const;
  void restore(const Snapshot& snapshot);
  /// reset() to a state whose velocities are those of State::time itself, as a body let go has them: for steps of dt
  /// they are taken half a step back, by the acceleration that scene and body have then. Throws Error as reset() does,
  /// and where dt is not above 0.
  void start(const State& state, double dt);

  /// n steps of dt seconds, dt finite and at least 1e-18 s. Looks at the scene for changes first. On failure the last
  /// good state is kept. n = 0 takes over the scene and moves nothing; residual, speed and at_rest then say nothing.
  StepReport step(int n, double dt);

  /// Steps until at rest or max_steps; the report counts all steps. Loads of later dates are not waited for: a body
  /// that rests before they act is at rest. Step to the last date first. At max_steps it ends with ok() and without
  /// at_rest: ask at_rest before taking the state for one of rest. Without any damping, under which nothing comes to
  /// rest, it does nothing and says invalid_step.
  StepReport run_to_rest(int max_steps, double dt);
  /// The same with another damping than the one of the options, for this call.
  StepReport run_to_rest(int max_steps, double dt, const Damping& damping);

  double time() const { return do_time(); }  ///< s, of the present state
  void read(State& state) const;             ///< copies the state out
  State read() const;

  /// Starts copying the present state out, without waiting for the device. At most three copies are on their way at a
  /// time; a fourth request takes the place of the third.
  void request_read();
  /// True when the oldest copy asked for has arrived; it is in `state` then. Never waits; false too when none was asked
  /// for. reset() drops copies on their way.
  bool collect(State& state);

  Energy energy() const;                                      ///< at the present state and scene; allocates
  Momentum momentum(const Vec3& about = Vec3::Zero()) const;  ///< of State::velocity as it stands

  /// Positions, and attractors P* (where the model has bases), without a copy. Valid until the next step(), reset() or
  /// the solver's end. With GL it waits for the device; bind the texture and draw from a context of the share group.
  ParticleBuffer position_buffer() const;
  ParticleBuffer attractor_buffer() const;  ///< empty where the law has no attractors

  /// What has been spent since the solver was made or clear_profile(), in the order of first use. Empty unless
  /// SolverOptions::profile. With GL it waits for the device.
  std::vector<PassProfile> profile() const;
  void clear_profile();

  /// What the particles do to a tool of the scene, and where it is now. Zero, and the scene's pose, before the first
  /// step. Throw Error for an unknown name; allocate nothing.
  const ToolForce& tool_force(std::string_view name) const;
  const ToolPose& tool_pose(std::string_view name) const;
  /// The same without looking for a name, for loops at a device's rate. Throw Error for a handle of another scene or
  /// of a tool that is gone.
  const ToolForce& tool_force(const ToolHandle& tool) const;
  const ToolPose& tool_pose(const ToolHandle& tool) const;
  /// How many particles a tool holds now; what grasp() and release() change, they change in the next step. Throw as
  /// above, never wait for a device.
  int held(std::string_view name) const;
  int held(const ToolHandle& tool) const;
  /// Where a needle is: `count` places, 2 or more, evenly along it from the tip to the hub, m. Throws Error for a tool
  /// that is none.
  VecList needle_points(std::string_view name, int count) const;
  /// Whether this backend takes scenes with tools. One that does not is not made for such a scene, and does not step
  /// it.
  bool takes_tools() const { return do_takes_tools(); }

  std::string device() const;  ///< what it runs on, for people and result files: a renderer, a kind of processor
  /// Why "auto" chose this backend; empty if the backend was named.
  std::string_view backend_reason() const { return backend_reason_; }

  /// Limit of dt in s for the free body at rest and this damping; holding particles can only raise it. Deformed bodies
  /// have a smaller one: work at half of it. Infinite for a body without any stiffness, for which any finite dt will do
  /// and step() takes no infinite one. See estimate_spectrum.
  double stable_step() const { return stable_step_; }

 protected:
  /// Checks the options, and that the tables are those of the scene's model; throws Error. A subclass ends its own
  /// constructor with reset().
  Solver(std::string name, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
         const SolverOptions& options);

  struct Motion {             ///< what a backend tells of the last of its steps
    int steps = 0;            ///< good steps done
    Index bad_particle = -1;  ///< >= 0: in the step after those this particle ran away; the step was undone
    bool lost = false;        ///< device lost
    int lost_volume = -1;     ///< >= 0: row of Scene::volume_constraints() that the step after those could not restore
    int full_needle = -1;     ///< >= 0: row of Scene::tools() whose hole the step after those has no room for
    bool force_clamped = false;     ///< an elastic acceleration was above StepPlan::largest_acceleration
    double max_acceleration = 0.0;  ///< m/s^2, free coordinates only
    double max_force = 0.0;         ///< N, likewise
    double max_speed = 0.0;         ///< m/s, likewise
    int steps_at_rest = 0;          ///< how many steps on end, up to the last one, were within the thresholds
  };
  struct StepPlan {  ///< what the non-virtual half asks for
    int steps = 0;
    double dt = 0.0;
    double damping_factor = 1.0;
    double speed_at_rest = 0.0;         ///< m/s threshold
    double acceleration_at_rest = 0.0;  ///< m/s^2 threshold
    double largest_acceleration = 0.0;  ///< m/s^2: elastic force over mass is limited to this; may be infinite
    double runaway_speed = 0.0;         ///< m/s: a faster particle, or one that is not finite, is a failure
    bool stop_at_rest = false;
    int rest_steps = 0;
  };

  /// Throws Error for the first part of a snapshot; for backends that have none.
  void refuse_parts(const Snapshot& snapshot) const;

  const Scene& scene() const { return *scene_; }
  LoadFrame& frame() { return frame_; }                  ///< prepared; a backend evaluates it at each step's time
  const LoadFrame& frame() const { return frame_; }      ///< of the scene as the last step or reset saw it
  Profile* profiling() const { return profile_.get(); }  ///< null unless SolverOptions::profile

 private:
  virtual void do_reset(const State& state) = 0;
  virtual void do_scene_changed() = 0;  ///< frame() has new sizes; may allocate
  /// Scene::mode_values() has other numbers of the same modes. Must not allocate, and takes its count of steps at rest
  /// back to 0.
  virtual void do_values_changed() { do_scene_changed(); }
  virtual Motion do_step(const StepPlan& plan) = 0;
  virtual void do_read(State& state) const = 0;
  virtual Energy do_energy() const = 0;
  virtual double do_time() const = 0;
  // What a backend may do better than by read(): without waiting, without a copy.
  virtual void do_request_read();
  virtual bool do_collect(State& state);
  virtual Momentum do_momentum(const Vec3& about) const;
  virtual ParticleBuffer do_position_buffer() const;
  virtual ParticleBuffer do_attractor_buffer() const;
  virtual std::string do_device() const = 0;
  // Backends that keep more than a State, or keep it more exactly, say so here.
  virtual void do_snapshot(Snapshot& snapshot) const;
  virtual void do_restore(const Snapshot& snapshot);
  /// What the scene holds that this backend does not take, a sentence, static text; null: nothing. As it stands, all
  /// that a backend has to add code for.
  virtual const char* do_cannot() const;
  virtual bool do_takes_tools() const { return false; }
  virtual bool do_takes_volumes() const { return false; }           ///< keeps them: Scene::constrain_volume
  virtual const ToolReport& do_tool_report(std::size_t row) const;  ///< of Scene::tools(), of the version last seen
  virtual void do_profile() const {}  ///< brings profiling(), which is not null, up to date

  friend std::unique_ptr<Solver> make_solver(std::string_view, std::shared_ptr<const TopologyTextures>, const Scene&,
                                             const SolverOptions&);
  void require_fitting(const State& state) const;
  void require_supported() const;
  void follow_scene();
  std::size_t tool_row(std::string_view name) const;
  std::size_t tool_row(const ToolHandle& tool) const;
  bool any_tool_grasps() const;
  StepReport advance(int n, double dt, bool stop_at_rest, const Damping& damping);
  Motion run(const StepPlan& plan, StepReport& report);
  Motion run_with_progress(const StepPlan& plan, StepReport& report);

  std::string name_, backend_reason_;
  std::vector<State> copies_;          // of do_request_read's plain way
  mutable VecList shown_, attracted_;  // of the plain buffers
  std::shared_ptr<const TopologyTextures> topology_;
  const Scene* scene_;
  SolverOptions options_;
  LoadFrame frame_;
  std::uint64_t scene_version_ = 0, values_version_ = 0;
  mutable std::optional<std::uint64_t> topology_hash_;
  std::unique_ptr<Profile> profile_;
  int steps_a_slice_ = 1;  // between two looks at the clock, where progress is asked for
  Spectrum spectrum_;
  double stable_step_ = 0.0;
  double spacing_ = 0.0;
};

/// Makes a solver, at rest. "auto" takes "cpu", or where a GPU was measured to be faster "gl-compute" ("gl" on one that
/// has no compute shaders), or "reference" where single precision cannot hold the body; backend_reason() says why.
/// Throws Error that lists the known names and, for one not built, how to.
std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene& scene,
                                    const TopologyOptions& topology = {}, const SolverOptions& options = {});
std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene&& scene,
                                    const TopologyOptions& topology = {},
                                    const SolverOptions& options = {}) = delete;  ///< the scene must outlive it

/// The same over tables built before, which any number of solvers may share. Throws Error, with what differs, when
/// anything that build_topology() read of the model has changed since: rest places, masses, cells, materials,
/// stiffnesses, neighbours. A copy of the model is as good as the model.
std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene& scene, const SolverOptions& options = {});
std::unique_ptr<Solver> make_solver(std::string_view backend, std::shared_ptr<const TopologyTextures> topology,
                                    const Scene&& scene, const SolverOptions& options = {}) = delete;

/// Names make_solver takes in this build, "auto" not among them.
std::vector<std::string> backend_names();

/// Empty where this machine can run the backend; else the reason in a sentence: a library that is missing, a driver
/// that gives no context. Throws Error for an unknown name.
std::string why_unavailable(std::string_view backend, const SolverOptions& options = {});

}  // namespace phymul
