// SPDX-License-Identifier: MIT
#include "planner.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "base/compiler.h"

namespace phymul {
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
