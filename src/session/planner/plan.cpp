// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/plan.h>

#include <cmath>
#include <memory>

#include "base/bounding_box.h"
#include "base/decimal.h"
#include "plan_text.h"
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

}  // namespace phymul
