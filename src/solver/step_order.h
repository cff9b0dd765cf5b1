// SPDX-License-Identifier: MIT
//
// The order of a step, for all backends that step one by one: which stage follows which, which step counts, when a
// motion rests and ends. Each backend executes the stages in its own way, and has none for what a scene lacks.
//
//   begin         loads and imposed positions, at the step's start and end
//   pull_joints   forces of springs, at the start
//   find_forces   elastic and dissipative ones
//   add_substeps  what small cells change of them within the step
//   limit         SolverOptions::max_displacement_per_step; then the springs' forces are added
//   solve_joints  what the implicit ones change
//   predict       where each particle would go by itself
//   touch         tools, contacts, volume constraints: they push there
//   move          and measures
//   settle        the forces of implicit joints, and what else than particles is not finite
//   accept        the step counts: its end is the state
//   drop_step     it does not
#pragma once

#include <phymul/backend.h>

namespace phymul {

/// A step in which no free coordinate is faster or more accelerated is one at rest.
struct RestThresholds {
  double speed = 0.0;         ///< m/s
  double acceleration = 0.0;  ///< m/s^2
};
/// Nothing rests while a fluid flows so fast, m/s (KeptVolumes::flow()).
inline RestThresholds with_flow(double flow, const RestThresholds& rest) {
  return flow > rest.speed ? RestThresholds{-1.0, -1.0} : rest;
}

/// A friend of the backend.
struct StepOrder {
  template <class Backend>
  static typename Backend::Motion run(Backend& backend, const typename Backend::StepPlan& plan) {
    typename Backend::Motion motion;
    motion.steps_at_rest = backend.steps_at_rest();
    while (motion.steps < plan.steps && step(backend, plan, motion)) {
    }
    return motion;
  }

  /// False where the motion ends with this step: it does not count, or the body rests.
  template <class Backend>
  static bool step(Backend& backend, const typename Backend::StepPlan& plan, typename Backend::Motion& motion) {
    if (!attempt(backend, plan, motion)) {
      backend.drop_step();
      return false;
    }
    backend.accept(plan, motion);
    ++motion.steps;
    const RestThresholds rest = backend.rest_now(plan, motion);
    const bool quiet = motion.max_speed <= rest.speed && motion.max_acceleration <= rest.acceleration;
    motion.steps_at_rest = quiet ? motion.steps_at_rest + 1 : 0;
    backend.steps_at_rest() = motion.steps_at_rest;
    return !(plan.stop_at_rest && motion.steps_at_rest >= plan.rest_steps);
  }

 private:
  /// False where the step does not count; the motion says why.
  template <class Backend>
  static bool attempt(Backend& backend, const typename Backend::StepPlan& plan, typename Backend::Motion& motion) {
    const bool last = motion.steps + 1 == plan.steps;
    backend.begin(plan);
    if (backend.has_joints()) backend.pull_joints(plan);
    backend.find_forces(plan, last);
    if (backend.has_substeps()) backend.add_substeps(plan);
    backend.limit(plan);
    if (backend.has_implicit_joints()) backend.solve_joints(plan);
    backend.predict(plan);
    if (backend.touches()) motion.lost_volume = backend.touch(plan);
    if (motion.lost_volume >= 0) return false;
    motion.bad_particle = backend.move(plan, motion);
    if (motion.bad_particle >= 0 || motion.lost_volume >= 0) return false;
    motion.not_finite = backend.settle();
    return *motion.not_finite == '\0';
  }
};

}  // namespace phymul
