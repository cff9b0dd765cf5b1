// SPDX-License-Identifier: MIT
//
// What Solver::step() and Solver::run_to_rest() return.
#pragma once

#include <phymul/types.h>

#include <string>

namespace phymul {

enum class StepStatus {
  ok,
  invalid_step,   ///< the arguments make no sense; nothing was done
  unstable_step,  ///< dt is above the step limit and UnstableStep::refuse is set; nothing was done
  /// A particle got a position that is not finite or a speed above a million mean spacings times omega_max, or a tool,
  /// thread, joint or fluid a number that is not finite. The step was undone.
  not_finite,
  device_lost,  ///< the GPU or its context failed
  volume_lost,  ///< a volume constraint (Scene::constrain_volume) could not be satisfied; the step was undone
  /// Every part of the body is held, domains are beyond the law, and a particle is farther than ten times the size of
  /// the body from where it may be. The state is that of the time in the report; Simulation::rewind or restore goes
  /// back. Not reported by the backends gl and gl-compute.
  carried_away,
  not_supported,  ///< the backend does not support something in the scene (tools, joints, volume constraints,
                  ///< contacts, factors of stiffness), dissipation, or substeps: see cause; nothing was done
};

struct StepReport {
  StepStatus status = StepStatus::ok;
  int steps = 0;              ///< number of steps that this call has completed
  double time = 0.0;          ///< s, of the state reached; after a failure that of the last good state
  double dt = 0.0;            ///< s, as passed
  double stable_step = 0.0;   ///< s, Solver::stable_step(), with the damping of this call
  bool beyond_limit = false;  ///< dt was above stable_step, and SolverOptions::on_unstable allows that
  bool at_rest = false;       ///< the rest test (SolverOptions::rest_tolerance) holds at the end; not part of ok()
  double residual = 0.0;      ///< N, largest net force on a free particle in the last step
  double max_speed = 0.0;     ///< m/s, largest speed
  /// By how much deformation can have raised the largest eigenvalue of the stiffness over the masses in the last step:
  /// frequency_growth() (elasticity.h). Infinite: no bound is known (backends gl and gl-compute, bodies without a
  /// material); 0: none of this call.
  double growth = 0.0;
  /// Domains (Law::particle_averaged) that are beyond the law in the last step, and of these the inverted ones
  /// (StrainSummary in elasticity.h). 0 on the backends gl and gl-compute, which do not count them.
  Index beyond_law = 0, inverted = 0;
  Index first_beyond = -1;    ///< while there are any: a particle that was the first to be found there; else -1
  double beyond_since = 0.0;  ///< s, time of the end of the call that found it
  /// An elastic force was limited in some step of this call: SolverOptions::max_displacement_per_step.
  bool force_clamped = false;
  int springs_broken = 0;  ///< springs of joints that broke in this call
  /// Punctures in this call below Needle::puncture, because the tissue under the tip had reached its limit.
  int tissue_gave_way = 0;
  /// Simulation: cells that blades have passed, or that should have torn, and that could not part, because they were
  /// cut three times already, the spare particles (with_spare_particles) do not suffice, or SolverOptions::max_substeps
  /// is above 1.
  int uncut = 0;
  int cut_later = 0;       ///< Simulation: cells that blades have passed and that wait for their cuts (tick_budget)
  int torn = 0;            ///< Simulation: cells that tore at the end of this call (Scene::tear)
  bool stopped = false;    ///< SolverOptions::progress ended the call before its last step
  Index particle = -1;     ///< row of the model: where a failure happened; -1: unknown
  const char* cause = "";  ///< likely cause of a failure; static text

  bool ok() const { return status == StepStatus::ok; }
  std::string message() const;  ///< one sentence for people; allocates
};

enum class RestStatus {
  converged,   ///< the body is at rest
  step_limit,  ///< max_steps were done and the body is not at rest
  failed,      ///< a step failed: see RestResult::report
  stopped      ///< SolverOptions::progress ended the call
};

/// Result of Solver::run_to_rest().
struct RestResult {
  RestStatus status = RestStatus::failed;
  StepReport report;  ///< of all steps of the call
  /// Only if converged or step_limit: a particle one of whose bases has collapsed to a line or a point, else -1.
  /// Such a base has no direction. A body that is in one point is at rest and cannot return by itself.
  Index collapsed = -1;
  /// Only if converged or step_limit: a cell that is flat or turned inside out, else -1. Springs can keep such states
  /// at rest; at the rim of a clamp such a cell can keep its particles moving. If other calls leave the body moving,
  /// call first_folded_cell() (monitor.h) and first_collapsed() (elasticity.h).
  Index folded = -1;
  Vec3 folded_at{0, 0, 0};  ///< m, mean of that cell's vertices at rest
  /// Only if step_limit: a particle of a part that loads push and that nothing holds (no imposed position or joint that
  /// is not broken, and the scene has no tools, threads or contacts), else -1. Such a part moves away unless its loads
  /// balance.
  Index loose = -1;

  bool converged() const { return status == RestStatus::converged; }
  std::string message() const;  ///< one sentence for people; allocates
};

}  // namespace phymul
