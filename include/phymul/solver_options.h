// SPDX-License-Identifier: MIT
//
// SolverOptions: how a solver moves a body. Everything has a default.
#pragma once

#include <phymul/elasticity.h>
#include <phymul/gl.h>
#include <phymul/task_runner.h>

#include <functional>
#include <memory>
#include <optional>

namespace phymul {

/// Velocity damping. A rate has the same effect for every step size; the factor is the d of the 2007 thesis. Damping
/// acts on the motion relative to the world, not to the body: a free body under gravity g falls no faster than g /
/// rate. Damping of deformation alone: Material::retardation_time.
struct Damping {
  double rate = 0.0;                  ///< 1/s, >= 0: each step multiplies velocities by exp(-rate dt)
  double factor = 1.0;                ///< d in [0, 1], applied once per step in addition to the rate; 1: no damping
  double factor_at(double dt) const;  ///< both combined, for a step of dt seconds
  bool operator==(const Damping&) const = default;
};

enum class UnstableStep {
  refuse,  ///< step() does nothing and returns StepStatus::unstable_step
  allow    ///< step() runs and sets StepReport::beyond_limit
};

/// Passed to SolverOptions::progress.
struct StepProgress {
  int steps = 0;           ///< done by this call so far
  int of = 0;              ///< steps requested; for run_to_rest() the maximum
  double time = 0.0;       ///< s, of the present state
  double residual = 0.0;   ///< N, as StepReport::residual
  double max_speed = 0.0;  ///< m/s
};

/// make_solver throws Error for a value out of its range.
struct SolverOptions {
  Damping damping{};
  UnstableStep on_unstable = UnstableStep::refuse;
  /// Rest test, independent of dt and scale. > 0, no unit. With the mean spacing h and tau = 1 / omega_max, a body is
  /// at rest if for `rest_steps` consecutive steps every free particle has speed * tau <= rest_tolerance * h and net
  /// force / mass * tau^2 <= rest_tolerance * h. In single precision ("cpu", GL) rounding alone moves a body that rests
  /// displaced by u. There the right-hand sides are therefore at least 8 * 2^-24 * u, with the body's largest u
  /// (docs/decisions/2026-11-21-rest-test-of-float-backends.md). What flows through openings of fluids counts as the
  /// speed of a cube's sides that would take it up, the cube of VolumeConstraint::volume.
  double rest_tolerance = 1e-8;
  int rest_steps = 16;
  /// Sleep: parts of a body that rest cost nothing. Backend "cpu", bodies with a material (Law::particle_averaged) and
  /// without walls. The other backends and laws have no sleep and ignore it. Empty: off. 0: only parts whose state
  /// repeats itself to the last bit are skipped, and the results are those without sleep. Above 0, in the units of
  /// rest_tolerance: a block of some hundred neighbouring particles stays where it is, at speed 0, if for `rest_steps`
  /// consecutive steps all its free particles have speed * tau <= sleep_tolerance * h and net force / mass * tau^2 <=
  /// sleep_tolerance * h. It moves again in the step in which a net force is above that, and when a tool, a contact, a
  /// volume constraint or an imposed motion moves one of its particles. So no net force above m h sleep_tolerance /
  /// tau^2, or a twentieth of the weight if that is less, is ever neglected (rounding: as for rest_tolerance, with the
  /// block's u). docs/guide/choosing.md has the error of some tolerances. run_to_rest() skips only parts whose state
  /// repeats itself. No effect if a material dissipates. make_solver throws Error for a negative value, NaN or
  /// infinity.
  std::optional<double> sleep_tolerance{};
  /// Local time steps: parts that need a shorter step than the rest do not limit the step of the whole body. >= 1; 1:
  /// off. Backends "reference" and "cpu", bodies with a material (Law::particle_averaged); with walls joints alone.
  /// - Materials that are stiffer, such as a tumour in soft tissue, take up to this many substeps within each step
  ///   (Solver::substeps), unless a material dissipates. Vibrations inside them that are faster than the step are
  ///   slowed down, as by a larger mass, which Solver::energy() does not count.
  /// - Parts with smaller cells, such as a duct, get a larger inertia for motions finer than the spacing of the rest.
  /// - Joints that cannot go slack, of 48 springs together, are solved implicitly, as by a larger mass of the motion
  ///   that stretches them. Solver::energy() counts these masses and those of small cells.
  /// The solver chooses parts and numbers by their cost; where they save less than a tenth, it uses one step for all.
  /// stable_step() is that of the whole scheme. Rest shapes are the same and linear momentum is conserved. Making the
  /// solver takes two to three times as long. make_solver throws Error together with sleep_tolerance. See
  /// docs/guide/choosing.md.
  int max_substeps = 1;
  /// In mean spacings, > 0. An elastic force that alone would move its particle further than this in one step is
  /// limited to that distance, and StepReport::force_clamped is set. Forces of this size occur only in states that real
  /// tissue does not reach (flattened, mirrored, scattered). There an explicit step overshoots; with the limit bodies
  /// return from such states at half the step limit. Momentum and energy are not conserved while the limit acts. The
  /// part withheld from a particle that a tool presses or holds is added to that tool's force. The limit is off for
  /// steps beyond the step limit and for models that are unstable at rest or flutter, because it would hide their
  /// growth. Infinite: always off.
  double max_displacement_per_step = 0.15;
  /// Spectrum of the same topology at rest, if known. It saves the estimate, which takes about a hundred force
  /// evaluations. With a wrong spectrum stable_step() and the rest test are wrong; the library cannot detect this.
  std::optional<Spectrum> spectrum{};
  /// Backend "cpu": number of threads. 0: as many as the body has work for, at most the number of processors. Results
  /// do not depend on it.
  int threads = 0;
  /// Backend "cpu": threads of the host to step with, at most TaskRunner::width() of them and at most `threads` unless
  /// that is 0. Empty: the solver starts its own.
  std::shared_ptr<TaskRunner> runner{};
  /// Called by step() and run_to_rest() between two steps, at most every `progress_seconds` and never after the last
  /// step. If it returns false, the call ends there with StepReport::stopped. Exceptions pass through to the caller of
  /// step(); the state is then that of the last call of `progress`. It may read the solver, but must not step or reset
  /// it or change its scene. It does not change trajectories. It is not called if the scene has tools or threads:
  /// they, and what holds them, move evenly over all steps of a call.
  std::function<bool(const StepProgress&)> progress{};
  double progress_seconds = 0.5;  ///< s of wall time, >= 0; 0: after every step
  bool profile = false;           ///< measure passes for Solver::profile(); false: no clock is read
  GlOptions gl{};                 ///< of the GL backends; the other backends ignore it
};

}  // namespace phymul
