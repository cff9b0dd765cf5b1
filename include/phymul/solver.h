// SPDX-License-Identifier: MIT
//
// Solver: moves a body through time. One abstract class, backends by name.
#pragma once

#include <phymul/elasticity.h>
#include <phymul/gl.h>
#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

/// Loss of velocity. A rate gives the same result whatever the step; the raw factor is the thesis' d.
struct Damping {
  double rate = 0.0;                  ///< 1/s, >= 0: velocity is multiplied by exp(-rate dt) each step
  double factor = 1.0;                ///< raw d per step in [0, 1], on top of the rate; 1 takes nothing
  double factor_at(double dt) const;  ///< both together, for a step of dt
};

enum class UnstableStep {
  refuse,  ///< step() does nothing and says unstable_step
  allow    ///< step() goes on; the report says so
};

struct SolverOptions {
  Damping damping;
  UnstableStep on_unstable = UnstableStep::refuse;
  /// A body rests when, for `rest_steps` steps on end, no free particle's speed times tau exceeds rest_tolerance * h
  /// and no net force over mass times tau^2 does; h is the mean spacing, tau = 1 / omega_max. Independent of dt and
  /// scale.
  double rest_tolerance = 1e-8;
  int rest_steps = 16;
  /// An elastic force that by itself would move its particle by more than this many mean spacings in one step is cut to
  /// that; the report says so. Forces of this size belong to states no tissue is in (flattened, mirrored, scattered),
  /// where an explicit step overshoots: cut, bodies return from them at half the step limit. Momentum and energy are
  /// not kept while it acts. Off (whatever its value) for steps beyond the limit and for models that are unstable at
  /// rest or flutter, whose growth it would hide; infinite: always off.
  double largest_push = 0.1;
  /// Of these very tables at rest, where it is known: saves estimating it, which takes a hundred force evaluations or
  /// so. A wrong one makes stable_step() and the rest test wrong.
  std::optional<Spectrum> spectrum;
  /// Of the backend "cpu": threads to run on. 0: as many as the body has work for, up to the processors. Results do not
  /// depend on it.
  int threads = 0;
  GlOptions gl;  ///< of the GL backends; the others do not look at it
};

/// not_finite: a particle would have left the finite numbers, or run faster than a million spacings times omega_max,
/// which no body survives; the step was not taken.
enum class StepStatus { ok, invalid_step, unstable_step, not_finite, device_lost };

struct StepReport {
  StepStatus status = StepStatus::ok;
  int steps = 0;              ///< steps done by this call
  double time = 0.0;          ///< s, of the state reached (of the last good one after a failure)
  double dt = 0.0;            ///< s, as asked
  double stable_step = 0.0;   ///< s, limit at rest; see stable_step()
  bool beyond_limit = false;  ///< dt was above it and allowed
  bool at_rest = false;       ///< the rest test held at the end
  double residual = 0.0;      ///< largest net force on a free particle at the last step, N
  double max_speed = 0.0;     ///< largest speed, m/s
  bool cut = false;           ///< an elastic force was cut in some step done: SolverOptions::largest_push
  /// run_to_rest() that came to rest: a particle one of whose bases has collapsed to a line or a point, else -1. Such a
  /// base has no direction; a body all in one point is at rest so and cannot come back by itself.
  Index collapsed = -1;
  Index particle = -1;     ///< culprit of a failure, row of the model
  const char* cause = "";  ///< likely cause of a failure, static text

  bool ok() const { return status == StepStatus::ok; }
  std::string message() const;  ///< a sentence for a person; allocates
};

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

/// step() throws nothing but std::bad_alloc, and allocates only in the first step after a change of the scene
/// ("reference": after its first force or first imposed position); read() is the one call that waits for a device. Not
/// thread-safe; two solvers are independent, and may share a scene that nobody changes meanwhile. Keeps a reference to
/// the scene and, through it, to the model, which must both outlive it and of which the model must not change.
class Solver {
 public:
  virtual ~Solver() = default;
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  std::string_view name() const { return name_; }
  const Model& model() const { return scene_->model(); }
  const TopologyTextures& topology() const { return *topology_; }

  /// Starts from a state; throws Error when its sizes do not fit, a value is not finite, or z is not 0 in a
  /// two-dimensional model (state untouched then).
  void reset(const State& state);
  void reset();  ///< the rest shape

  /// n steps of dt seconds. Looks at the scene for changes first. On failure the last good state is kept. n = 0 takes
  /// over the scene and moves nothing; residual, speed and at_rest then say nothing.
  StepReport step(int n, double dt);

  /// Steps until at rest or max_steps; the report counts all steps. Loads of later dates are not waited for: a body
  /// that rests before they act is at rest. Step to the last date first.
  StepReport run_to_rest(int max_steps, double dt);

  void read(State& state) const;  ///< copies the state out
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

  std::string device() const;  ///< what it runs on, for people and result files: a renderer, a kind of processor
  std::string_view choice() const { return choice_; }  ///< why "auto" took this backend; empty when asked for by name

  /// Limit of dt in s for the free body at rest and this damping; holding particles can only raise it. Deformed bodies
  /// have a smaller one: work at half of it. Infinite for a body without any stiffness. See estimate_spectrum.
  double stable_step() const { return stable_step_; }

 protected:
  /// Checks the options, and that the tables are those of the scene's model; throws Error. A subclass ends its own
  /// constructor with reset().
  Solver(std::string name, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
         const SolverOptions& options);

  struct Motion {                   ///< what a backend tells of the last of its steps
    int steps = 0;                  ///< good steps done
    Index bad_particle = -1;        ///< >= 0: in the step after those this particle ran away; the step was undone
    bool lost = false;              ///< device lost
    bool cut = false;               ///< an elastic acceleration was above StepPlan::largest_acceleration
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
    double largest_acceleration = 0.0;  ///< m/s^2: elastic force over mass beyond this is cut to it; may be infinite
    double runaway_speed = 0.0;         ///< m/s: a faster particle, or one that is not finite, is a failure
    bool stop_at_rest = false;
    int rest_steps = 0;
  };

  const Scene& scene() const { return *scene_; }
  const SolverOptions& options() const { return options_; }
  LoadFrame& frame() { return frame_; }              ///< prepared; a backend evaluates it at each step's time
  const LoadFrame& frame() const { return frame_; }  ///< of the scene as the last step or reset saw it

 private:
  virtual void do_reset(const State& state) = 0;
  virtual void do_scene_changed() = 0;  ///< frame() has new sizes; may allocate
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

  friend std::unique_ptr<Solver> make_solver(std::string_view, std::shared_ptr<const TopologyTextures>, const Scene&,
                                             const SolverOptions&);
  void follow_scene();
  StepReport advance(int n, double dt, bool stop_at_rest);

  std::string name_, choice_;
  std::vector<State> copies_;          // of do_request_read's plain way
  mutable VecList shown_, attracted_;  // of the plain buffers
  std::shared_ptr<const TopologyTextures> topology_;
  const Scene* scene_;
  SolverOptions options_;
  LoadFrame frame_;
  std::uint64_t scene_version_ = 0;
  Spectrum spectrum_;
  double stable_step_ = 0.0;
  double spacing_ = 0.0;
};

/// Makes a solver, at rest. "auto" takes "cpu", or "gl" where a GPU was measured to be faster, or "reference" where
/// single precision cannot hold the body; Solver::choice() says why. Throws Error that lists the known names and, for
/// one not built, how to.
std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene& scene,
                                    const TopologyOptions& topology = {}, const SolverOptions& options = {});
std::unique_ptr<Solver> make_solver(std::string_view backend, const Model& model, const Scene&& scene,
                                    const TopologyOptions& topology = {},
                                    const SolverOptions& options = {}) = delete;  ///< the scene must outlive it

/// The same over tables built before, which any number of solvers may share. Throws Error when the model has changed
/// since.
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
