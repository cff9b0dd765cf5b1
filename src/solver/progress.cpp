// SPDX-License-Identifier: MIT
//
// Progress of long calls: the plan of a call is divided into slices, and the clock is read between them. A backend
// keeps its count of steps at rest from one do_step() to the next, so the slices change nothing.
#include <phymul/backend.h>

#include <algorithm>
#include <chrono>

namespace phymul {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// A slice takes about this share of the time between two reports.
constexpr double slice_share = 0.25;

int next_slice(int steps, double seconds, double wanted) {
  const double fitting = seconds > 0.0 ? wanted / seconds * steps : 2.0 * steps;
  return static_cast<int>(std::clamp(fitting, 1.0, std::min(2.0 * steps, 1e9)));
}

}  // namespace

SolverBackend::Motion SolverBackend::run(const StepPlan& plan, StepReport& report) {
  // A tool, and what holds a thread, goes its way evenly over the steps of one do_step(): slices would make it jump.
  const bool in_slices = options_.progress && scene_->tools().empty() && scene_->threads().empty();
  return in_slices ? run_with_progress(plan, report) : do_step(plan);
}

SolverBackend::Motion SolverBackend::run_with_progress(const StepPlan& plan, StepReport& report) {
  Motion motion;
  Clock::time_point last_call = Clock::now(), slice_began = last_call;
  while (true) {
    StepPlan slice = plan;
    slice.steps = std::min(steps_a_slice_, plan.steps - motion.steps);
    const Motion done = do_step(slice);
    if (done.lost) return done;  // the state is an older one, whatever was done in this call
    // A slice whose first step failed knows nothing of speeds.
    const double speed = done.steps > 0 ? done.max_speed : motion.max_speed;
    const int steps = motion.steps + done.steps;
    const bool clamped = motion.force_clamped || done.force_clamped;
    motion = done;
    motion.steps = steps;
    motion.max_speed = speed;
    motion.force_clamped = clamped;
    const bool rests = plan.stop_at_rest && motion.steps_at_rest >= plan.rest_steps;
    if (motion.steps >= plan.steps || done.steps < slice.steps || rests) return motion;

    const Clock::time_point now = Clock::now();
    steps_a_slice_ =
        next_slice(slice.steps, seconds_between(slice_began, now), slice_share * options_.progress_seconds);
    if (seconds_between(last_call, now) >= options_.progress_seconds) {
      const StepProgress progress{.steps = motion.steps,
                                  .of = plan.steps,
                                  .time = do_time(),
                                  .residual = motion.max_force,
                                  .max_speed = motion.max_speed};
      if (!options_.progress(progress)) {
        report.stopped = true;
        return motion;
      }
      last_call = Clock::now();
    }
    slice_began = Clock::now();
  }
}

}  // namespace phymul
