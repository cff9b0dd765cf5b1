// SPDX-License-Identifier: MIT
#include <memory>
#include <sstream>

#include "handles.h"

using namespace phymul;
using namespace phymul::c;

namespace {

phymul_candidate candidate_of(const PlanCandidate& from) {
  return {.spacing = from.spacing,
          .backend = from.backend.c_str(),
          .step = from.step,
          .threads = from.threads,
          .unused = 0};
}

phymul_trial trial_of(const PlanTrial& from) {
  return {.candidate = candidate_of(from.candidate),
          .mean_spacing = from.mean_spacing,
          .error = from.error,
          .tick = from.tick,
          .rest = from.rest,
          .particles = from.particles,
          .keeps_error = from.keeps_error,
          .keeps_time = from.keeps_time,
          .unused = 0};
}

SceneBuilder builder_of(phymul_builder builder, void* user) {
  return [builder, user](const PlanCandidate& wanted) {
    last_error().clear();
    const phymul_candidate candidate = candidate_of(wanted);
    phymul_simulation* made = nullptr;
    const phymul_status status = builder(user, &candidate, &made);
    const std::unique_ptr<phymul_simulation> owner(made);
    const std::string reason = last_error().empty() ? "" : ": " + last_error();
    if (status == PHYMUL_INTERNAL) throw Failure{status, "the builder ended the planning" + reason};
    if (status != PHYMUL_OK || !made)
      throw Error("the builder returned " +
                  (status == PHYMUL_OK ? std::string("no simulation") : "the status " + std::to_string(status)) +
                  reason);
    return std::move(owner->simulation);
  };
}

PlanOptions plan_options(const phymul_plan_options* given) {
  const phymul_plan_options from = options_of(given, "options of a plan");
  PlanOptions options;
  options.max_error = from.max_error;
  options.rate = from.rate;
  options.rest_in = from.rest_in;
  if (from.head_room != 0.0) options.head_room = from.head_room;
  options.probe_time = from.probe_time;
  options.coarsest = from.coarsest;
  options.finest = from.finest;
  if (from.budget != 0.0) options.budget = from.budget;
  options.most_threads = from.most_threads;
  if (from.backends) {
    options.backends.clear();
    std::istringstream names(from.backends);
    for (std::string name; std::getline(names, name);) options.backends.push_back(name);
  }
  return options;
}

/// Null where the plan has none.
const PlanTrial* choice_of(const phymul_plan* handle, int32_t which) {
  const Plan& plan = need(handle, "a plan").plan;
  require_kind(which, PHYMUL_CHOSEN, 3, "a choice");
  if (which == PHYMUL_CHOSEN) return plan.kept ? &plan.chosen : nullptr;
  const std::optional<PlanTrial>& offer = which == PHYMUL_CHEAPEST ? plan.cheapest : plan.most_accurate;
  return offer ? &*offer : nullptr;
}

}  // namespace

phymul_status phymul_plan_create(phymul_builder builder, void* user, const phymul_plan_options* options,
                                 phymul_plan** made) {
  return guarded([&] {
    need(made, "a place for the plan");
    if (!builder) throw Error("expected a builder, got NULL");
    auto result = std::make_unique<phymul_plan>();
    result->plan = plan(builder_of(builder, user), plan_options(options));
    result->report = result->plan.report();
    for (const PlanTrial& trial : result->plan.trials) result->trials.push_back(trial_of(trial));
    *made = result.release();
  });
}

void phymul_plan_free(phymul_plan* plan) {
  delete plan;
}

phymul_status phymul_plan_report(const phymul_plan* plan, const char** report) {
  return guarded([&] { need(report, "a place for the report") = need(plan, "a plan").report.c_str(); });
}

phymul_status phymul_plan_trials(const phymul_plan* plan, const phymul_trial** trials, int32_t* count) {
  return guarded([&] {
    const auto& all = need(plan, "a plan").trials;
    hand_out(all.data(), all.size(), trials, count, "a place for the trials");
  });
}

phymul_status phymul_plan_choice(const phymul_plan* plan, int32_t which, phymul_trial* trial, int32_t* exists) {
  return guarded([&] {
    const PlanTrial* choice = choice_of(plan, which);
    need(trial, "a place for the trial");
    need(exists, "a place for the answer") = choice != nullptr;
    if (choice) *trial = trial_of(*choice);
  });
}

phymul_status phymul_plan_make(const phymul_plan* plan, int32_t which, phymul_simulation** made) {
  return guarded([&] {
    need(made, "a place for the simulation");
    const PlanTrial* choice = choice_of(plan, which);
    if (!choice && plan->plan.kept) throw Error("the wishes are kept, so that there is PHYMUL_CHOSEN and no offer");
    // Without a choice make() throws, and names the offers.
    *made = new phymul_simulation{.simulation = choice ? plan->plan.make(*choice) : plan->plan.make(), .moved = true};
  });
}
