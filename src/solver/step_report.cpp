// SPDX-License-Identifier: MIT
//
// What reports say in words. Progress of long calls: the plan of a call is divided into slices, and the clock is read
// between them. A backend keeps its count of steps at rest from one do_step() to the next, so the slices change
// nothing.
#include <phymul/backend.h>
#include <phymul/step_report.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>

#include "base/decimal.h"

namespace phymul {
namespace {

/// `verdict`: "ok:" or "not at rest after".
std::string good_message(const StepReport& r, const char* verdict) {
  char text[512];
  std::snprintf(
      text, sizeof text, "%s %d steps to t = %.6g s, residual %.3g N, speed %.3g m/s%s%s%s%s", verdict, r.steps, r.time,
      r.residual, r.max_speed, r.at_rest ? ", at rest" : "", r.stopped ? "; stopped by SolverOptions::progress" : "",
      r.beyond_limit ? "; the step is beyond the stable step" : "",
      r.force_clamped ? "; elastic forces were clamped in some step, as where a tool jumps or a load acts at once"
                      : "");
  std::string all = text;
  if (r.beyond_law > 0) {
    std::snprintf(
        text, sizeof text,
        "; around %d %s the material is strained beyond the law%s, first around particle %d, found at t = %.6g s",
        static_cast<int>(r.beyond_law), r.beyond_law == 1 ? "particle" : "particles",
        r.inverted == 0 ? "" : (", inverted around " + std::to_string(r.inverted)).c_str(),
        static_cast<int>(r.first_beyond), r.beyond_since);
    all += text;
  }
  if (r.tissue_gave_way > 0) all += "; tissue gave way to a tip before the needle's puncture force";
  if (r.uncut > 0) {
    all += "; " + std::to_string(r.uncut) + (r.uncut == 1 ? " cell" : " cells") +
           " could not part: too few spare particles (with_spare_particles), three cuts there already, or max_substeps";
  }
  if (r.cut_later > 0) {
    all += "; " + std::to_string(r.cut_later) + (r.cut_later == 1 ? " cell is" : " cells are") +
           " passed by blades and cut in the next calls (tick_budget)";
  }
  if (r.springs_broken == 0) return all;
  return all + "; " + std::to_string(r.springs_broken) +
         (r.springs_broken == 1 ? " spring of a joint broke" : " springs of joints broke");
}

}  // namespace

std::string StepReport::message() const {
  char text[1024];
  switch (status) {
    case StepStatus::ok:
      return good_message(*this, "ok:");
    case StepStatus::invalid_step:
      std::snprintf(text, sizeof text, "invalid_step: dt = %g s: %s; nothing was done", dt, cause);
      break;
    case StepStatus::unstable_step:
      std::snprintf(
          text, sizeof text,
          "unstable_step: dt = %.6g s is above the stable step %.6g s of this body at rest; nothing was done. "
          "Use at most half of it, or UnstableStep::allow",
          dt, stable_step);
      break;
    case StepStatus::not_finite:
      if (particle < 0) {
        std::snprintf(text, sizeof text,
                      "not_finite: %s; the step after t = %.6g s (step %d of this call) was undone, the state at that "
                      "time is kept",
                      cause, time, steps + 1);
        break;
      }
      std::snprintf(text, sizeof text,
                    "not_finite: particle %d diverged (its speed is above a million times the wave speed, or not "
                    "finite) after t = %.6g "
                    "s (step %d of this call, "
                    "dt = %.6g s, stable step at rest %.6g s); the state at that time is kept. Likely cause: %s",
                    static_cast<int>(particle), time, steps + 1, dt, stable_step, cause);
      break;
    case StepStatus::carried_away:
      std::snprintf(
          text, sizeof text,
          "carried_away: particle %d is more than ten times the size of the body from where its loads can have "
          "brought it, at t = %.6g s, dt = %.6g s. Since t = %.6g s the material has been strained beyond the "
          "law, first around particle %d. Go back to a state before that; load more slowly, take shorter "
          "steps or refine the mesh there",
          static_cast<int>(particle), time, dt, beyond_since, static_cast<int>(first_beyond));
      break;
    case StepStatus::not_supported:
      std::snprintf(text, sizeof text, "not_supported: %s; nothing was done", cause);
      break;
    case StepStatus::device_lost:
      std::snprintf(text, sizeof text, "device_lost: the device failed after t = %.6g s", time);
      break;
    case StepStatus::volume_lost:
      std::snprintf(text, sizeof text,
                    "volume_lost: the volume of the closed surface at particle %d could not be restored after t = %.6g "
                    "s (step %d of this call); the state at that time is kept. Likely cause: %s",
                    static_cast<int>(particle), time, steps + 1, cause);
      break;
  }
  return text;
}

std::string RestResult::message() const {
  if (status == RestStatus::failed) return report.message();
  std::string text;
  if (loose >= 0) {
    text = "nothing holds the part of particle " + std::to_string(loose) +
           ": it moves away unless its loads balance; hold it, as with Scene::fix(). ";
  }
  text += good_message(report, converged() ? "ok:" : "not at rest after");
  if (collapsed >= 0) {
    text += "; a base of particle " + std::to_string(collapsed) +
            " has collapsed and has no direction: move some of its particles apart";
  }
  if (folded >= 0) {
    text += "; cell " + std::to_string(folded) + ", at " + place_text(folded_at) + " at rest, is flat or inside out: ";
    text += converged() ? "the body rests folded, which is not its rest shape"
                        : "it can keep its particles moving; hold less abruptly there or refine the mesh";
  }
  return text;
}

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
