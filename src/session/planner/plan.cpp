// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/plan.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <thread>

#include "base/box_tree.h"
#include "base/compiler.h"
#include "base/decimal.h"
#include "planner.h"

namespace phymul {
namespace {

constexpr double coarse_part_of_size = 0.25;  // a first spacing, of the box's largest side

void require(bool holds, const char* member, const std::string& expected, double value) {
  if (!holds)
    throw Error(std::string("PlanOptions::") + member + " must be " + expected + "; got " + to_decimal(value));
}

void require_valid(const PlanOptions& options) {
  const auto not_negative = [](double value) { return value >= 0.0 && std::isfinite(value); };
  require(options.max_error > 0.0 && options.max_error < 1.0, "max_error",
          "above 0 and below 1 (a share of the displacement)", options.max_error);
  require(not_negative(options.rate), "rate", "finite and at least 0, Hz", options.rate);
  require(options.rate == 0.0 || options.rate >= 1.0, "rate", "0 or at least 1 Hz", options.rate);
  require(not_negative(options.rest_in), "rest_in", "finite and at least 0, s", options.rest_in);
  require(not_negative(options.probe_time), "probe_time", "finite and at least 0, s", options.probe_time);
  require(not_negative(options.coarsest), "coarsest", "finite and at least 0, m", options.coarsest);
  require(not_negative(options.finest), "finest", "finite and at least 0, m", options.finest);
  require(options.head_room > 0.0 && options.head_room <= 1.0, "head_room", "above 0 and at most 1", options.head_room);
  require(options.budget > 0.0 && std::isfinite(options.budget), "budget", "finite and above 0, s", options.budget);
  require(options.most_threads >= 0, "most_threads", "at least 0", options.most_threads);
  require(!(options.coarsest > 0.0) || options.finest < options.coarsest, "finest", "below coarsest", options.finest);
  for (const double step : options.steps) require(step > 0.0 && step < 1.0, "steps", "above 0 and below 1 each", step);
  if (options.steps.empty()) throw Error("PlanOptions::steps must name a multiple of the stable step; got none");
  if (options.rate == 0.0 && options.rest_in == 0.0) {
    throw Error("PlanOptions: expected a rate (Hz) or rest_in (s) to be kept, got neither");
  }
  if (options.rest_in > 0.0 && options.probe_time > 0.0) {
    throw Error("PlanOptions: expected rest_in (at rest) or probe_time (in motion), got both");
  }
  if (options.before_tick && options.probe_time == 0.0) {
    throw Error("PlanOptions::before_tick is called in probe_time alone; got 0 s");
  }
}

/// Those that this machine can run; throws Error if there are none.
std::vector<std::string> runnable(const std::vector<std::string>& backends, std::vector<std::string>& notes) {
  std::vector<std::string> result;
  for (const std::string& name : backends) {
    if (name == "auto") throw Error("PlanOptions::backends: expected names of backends, got \"auto\"");
    const std::string why = why_unavailable(name);
    if (why.empty()) {
      result.push_back(name);
    } else {
      notes.push_back("backend \"" + name + "\" is omitted: " + why);
    }
  }
  if (!result.empty()) return result;
  throw Error("PlanOptions::backends: expected one that this machine can run, got " +
              (notes.empty() ? std::string("none") : notes.front()));
}

Plan plan_from(SceneBuilder builder, PlanOptions options, double guess) {
  if (!builder) throw Error("plan: expected a builder, got an empty function");
  require_valid(options);
  std::vector<std::string> notes;
  options.backends = runnable(options.backends, notes);
  Plan result = Planner(std::move(builder), std::move(options), guess).run();
  result.notes.insert(result.notes.begin(), notes.begin(), notes.end());
  return result;
}

template <class Shape>
SceneBuilder builder_of(const Shape& shape, SimulationOptions simulation, std::function<void(Simulation&)> fill) {
  if (!fill) throw Error("plan: expected a function that fills the scene, got an empty one");
  return [shape = std::make_shared<const Shape>(shape), simulation = std::move(simulation),
          fill = std::move(fill)](const PlanCandidate& candidate) {
    Simulation sim(make_body(*shape, {.spacing = candidate.spacing}), candidate.options(simulation));
    fill(sim);
    return sim;
  };
}

// Planner: which configuration of which spacing.

int processors() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

SimulationOptions PlanCandidate::options(SimulationOptions others) const {
  others.backend = backend;
  others.step = step;
  others.solver.threads = threads;
  return others;
}

Simulation Plan::make() const {
  if (kept) return make(chosen);
  std::string text = "Plan::make: the wishes are not kept. " + reason;
  if (const std::string offers = describe_offers(*this); !offers.empty()) text += ' ' + offers;
  throw Error(text);
}

Simulation Plan::make(const PlanTrial& trial) const {
  if (!builder) throw Error("Plan::make: expected the result of plan(), got an empty plan");
  return builder(trial.candidate);
}

Plan plan(SceneBuilder builder, PlanOptions options) {
  return plan_from(std::move(builder), std::move(options), 0.0);
}

Plan plan(const Surface& surface, SimulationOptions simulation, std::function<void(Simulation&)> fill,
          PlanOptions options) {
  const double size = surface.vertices.empty() ? 0.0 : bounding_box(surface.vertices).sizes().maxCoeff();
  return plan_from(builder_of(surface, std::move(simulation), std::move(fill)), std::move(options),
                   coarse_part_of_size * size);
}

Plan plan(const Solid& solid, SimulationOptions simulation, std::function<void(Simulation&)> fill,
          PlanOptions options) {
  const double guess = coarse_part_of_size * (solid.high - solid.low).maxCoeff();
  return plan_from(builder_of(solid, std::move(simulation), std::move(fill)), std::move(options), guess);
}

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

namespace {

PHYMUL_LIKE_PRINTF(1, 2) std::string text(const char* format, ...) {
  char buffer[256];
  va_list values;
  va_start(values, format);
  std::vsnprintf(buffer, sizeof buffer, format, values);
  va_end(values);
  return buffer;
}

std::string percent(double share) {
  return std::isnan(share) ? std::string("unknown") : text("%.3g %%", 100.0 * share);
}

std::string microseconds(double seconds) {
  return std::isnan(seconds) ? std::string("unknown") : text("%.4g us", 1e6 * seconds);
}

std::string time_of(const Plan& plan, const PlanTrial& trial) {
  std::string result;
  if (plan.options.rate > 0.0) result = "a tick takes " + microseconds(trial.tick);
  if (plan.options.rest_in > 0.0) {
    if (!result.empty()) result += ", ";
    result += std::isnan(trial.rest) ? std::string("rest is not found") : text("rest takes %.3g s", trial.rest);
  }
  return result;
}

std::string wish(const Plan& plan) {
  const PlanOptions& options = plan.options;
  std::string result = "Wish: an error of at most " + percent(options.max_error) + " of the displacement";
  if (options.rate > 0.0) {
    result += text("; ticks of 1/%g s, each in at most %.4g us (head room %g)", options.rate,
                   1e6 * options.head_room / options.rate, options.head_room);
  }
  if (options.rest_in > 0.0) {
    result += text("; the rest shape in at most %.3g s (head room %g)", options.head_room * options.rest_in,
                   options.head_room);
  }
  return result + ".\n";
}

std::string verdict(const Plan& plan, const PlanTrial& trial) {
  const PlanCandidate &a = trial.candidate, &b = plan.chosen.candidate;
  if (plan.kept && a.spacing == b.spacing && a.backend == b.backend && a.threads == b.threads && a.step == b.step) {
    return "chosen";
  }
  if (trial.particles == 0) return "not built";
  if (std::isnan(trial.error)) return "error unknown";
  if (trial.keeps_error) return trial.keeps_time ? "keeps both" : "too slow";
  const bool small = trial.error <= plan.options.max_error;  // but the finest body folds
  return std::string(small ? "error not certain" : "error too large") + (trial.keeps_time ? "" : ", too slow");
}

std::string row(const Plan& plan, const PlanTrial& trial) {
  const auto number = [](const char* format, double value) {
    return std::isnan(value) ? std::string("-") : text(format, value);  // NOLINT
  };
  std::string result = text("%10.3f %9d %8s %9s %9s", 1e3 * trial.candidate.spacing, trial.particles,
                            number("%.2f", 100.0 * trial.error).c_str(), number("%.1f", 1e6 * trial.tick).c_str(),
                            number("%.1f", trial.real_time).c_str());
  result += text(" %8s %-10s %7d %5.2f  ", number("%.3f", trial.rest).c_str(), trial.candidate.backend.c_str(),
                 trial.candidate.threads, trial.candidate.step);
  result += verdict(plan, trial);
  if (!trial.note.empty()) result += "; " + trial.note;
  return result + '\n';
}

}  // namespace

std::string describe(const PlanTrial& trial) {
  const PlanCandidate& it = trial.candidate;
  return text("%.4g mm, %d particles, ", 1e3 * it.spacing, trial.particles) + it.backend +
         text(" with %d thread%s, step %g", it.threads, it.threads == 1 ? "" : "s", it.step);
}

std::string describe_offers(const Plan& plan) {
  std::string result;
  if (plan.most_accurate) {
    result += "Most accurate in time: " + describe(*plan.most_accurate) + ": error " +
              percent(plan.most_accurate->error) + ", " + time_of(plan, *plan.most_accurate) + ". ";
  }
  if (plan.cheapest) {
    result += "Fastest of the coarsest body with the error: " + describe(*plan.cheapest) + ": error " +
              percent(plan.cheapest->error) + ", " + time_of(plan, *plan.cheapest) + ". ";
  }
  if (!result.empty()) result.pop_back();
  return result;
}

std::string reason_of_choice(const Plan& plan, const PlanTrial* coarser) {
  std::string result = "It is the coarsest body that keeps the error (" + percent(plan.chosen.error) + "), and " +
                       time_of(plan, plan.chosen) + "; ";
  if (!coarser) return result + "no coarser body was tried.";
  return result + "the next coarser one, " + text("%.4g mm, has ", 1e3 * coarser->candidate.spacing) +
         (std::isnan(coarser->error) ? "no known error." : percent(coarser->error) + '.');
}

std::string reason_of_refusal(const Plan& plan, const PlanTrial& finest, const std::string& ended) {
  if (std::isnan(plan.order)) {
    return "No error is known: that takes three bodies, and " + ended + ".";
  }
  if (plan.cheapest) return "No candidate that keeps the error is fast enough.";
  if (finest.error <= plan.options.max_error) {
    return "No error is certain, because cells of the finest body, " +
           text("%.4g mm, are flat or inside out at rest.", 1e3 * finest.candidate.spacing);
  }
  return "No body that was tried keeps the error; the finest, " +
         text("%.4g mm, has ", 1e3 * finest.candidate.spacing) + percent(finest.error) + ", and " + ended + ".";
}

std::string Plan::report() const {
  std::string result = wish(*this);
  result += "spacing mm particles  error %   tick us real time   rest s backend    threads  step  verdict\n";
  for (const PlanTrial& trial : trials) result += row(*this, trial);
  if (kept) {
    result += "Chosen: " + describe(chosen) + ". " + reason + '\n';
  } else {
    result += "Not kept. " + reason + '\n';
    if (const std::string offers = describe_offers(*this); !offers.empty()) result += offers + '\n';
  }
  for (const std::string& note : notes) result += "Note: " + note + ".\n";
  result += text("Planned in %.1f s.", seconds);
  if (!std::isnan(order)) result += text(" The error falls with the power %.2f of the spacing.", order);
  return result + '\n';
}

}  // namespace phymul
