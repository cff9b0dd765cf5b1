// SPDX-License-Identifier: MIT
//
// Planner: which configuration of which spacing.
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "plan_text.h"
#include "planner.h"

namespace phymul {
namespace {

int processors() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

bool Planner::keeps_time(const PlanTrial& trial) const {
  const PlanOptions& options = plan_.options;
  // Comparisons with NaN are false.
  if (options.rate > 0.0 && !(trial.tick * options.rate <= options.head_room)) return false;
  return options.rest_in == 0.0 || trial.rest <= options.head_room * options.rest_in;
}

/// s of wall time, of a tick or to the rest shape.
double Planner::most_seconds() const {
  const PlanOptions& options = plan_.options;
  return options.head_room * (options.rate > 0.0 ? 1.0 / options.rate : options.rest_in);
}

double Planner::cost(const PlanTrial& trial) const {
  return (plan_.options.rate > 0.0 ? trial.tick : trial.rest) * trial.candidate.threads;
}

/// With more than one thread only of the processor, where that is asked for.
std::vector<PlanCandidate> Planner::configurations(double spacing, int threads) const {
  std::vector<PlanCandidate> result;
  for (const std::string& backend : plan_.options.backends) {
    if (threads > 1 && backend != "cpu") continue;
    for (const double step : plan_.options.steps) result.push_back({spacing, backend, threads, step});
  }
  return result;
}

PlanTrial Planner::measured(Level& level, const PlanCandidate& candidate) {
  const auto is_it = [&](const PlanTrial& it) {
    const PlanCandidate& c = it.candidate;
    return c.spacing == candidate.spacing && c.backend == candidate.backend && c.threads == candidate.threads &&
           c.step == candidate.step;
  };
  if (is_it(level.trial)) return level.trial;
  if (const auto known = std::ranges::find_if(measured_, is_it); known != measured_.end()) return *known;
  PlanTrial trial = level.trial;
  trial.candidate = candidate;
  trial.tick = trial.real_time = PlanTrial::unknown;
  trial.keeps_time = false;
  trial.note.clear();
  if (prober_.left() < 0.0) {
    trial.note = "not measured: the budget ended";
  } else {
    try {
      const Probe probe = prober_.measure(candidate, level.probe);
      trial.tick = probe.tick;
      trial.rest = probe.rest_seconds;
      trial.real_time = prober_.tick_length() / probe.tick;
      trial.note = probe.failure.empty() ? probe.note : probe.failure;
      trial.keeps_time = probe.failure.empty() && keeps_time(trial);
    } catch (const std::exception& error) {
      trial.note = error.what();
    }
  }
  measured_.push_back(trial);
  return trial;
}

std::optional<PlanTrial> Planner::cheapest_in_time(Level& level, PlanTrial& fastest) {
  const int most = plan_.options.most_threads > 0 ? plan_.options.most_threads : processors();
  const double spacing = level.trial.candidate.spacing;
  const auto wall = [&](const PlanTrial& it) { return plan_.options.rate > 0.0 ? it.tick : it.rest; };
  std::optional<PlanTrial> best;
  fastest = level.trial;
  // All threads together are that much faster, at the very most.
  constexpr double most_gain = 1.2;
  for (int threads = 1; !best && threads <= most; threads = threads < most ? std::min(2 * threads, most) : most + 1) {
    for (const PlanCandidate& candidate : configurations(spacing, threads)) {
      const PlanTrial trial = measured(level, candidate);
      if (wall(trial) < wall(fastest)) fastest = trial;
      if (trial.keeps_time && (!best || cost(trial) < cost(*best))) best = trial;
    }
    if (wall(fastest) > most_gain * most * most_seconds()) break;
  }
  return best;
}

void Planner::choose() {
  const std::optional<std::size_t> kept = coarsest_kept();
  PlanTrial fastest;
  if (kept) {
    if (std::optional<PlanTrial> best = cheapest_in_time(levels_[*kept], fastest)) {
      plan_.kept = true;
      plan_.chosen = *best;
      plan_.reason = reason_of_choice(plan_, *kept > 0 ? &levels_[*kept - 1].trial : nullptr);
      return;
    }
    plan_.cheapest = fastest;
  }
  // Coarser is faster, so the first one found from the fine end is the most accurate.
  for (std::size_t k = levels_.size(); k-- > 0;) {
    Level& level = levels_[k];
    if (!level.has_field() || !std::isfinite(level.trial.error)) continue;
    if (kept && k >= *kept) continue;
    plan_.most_accurate = cheapest_in_time(level, fastest);
    if (plan_.most_accurate) break;
  }
  const auto finest = std::ranges::find_if(levels_.rbegin(), levels_.rend(), &Level::has_field);  // refine() has one
  plan_.reason = reason_of_refusal(plan_, finest->trial, ended_);
}

}  // namespace phymul
