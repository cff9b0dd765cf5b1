// SPDX-License-Identifier: MIT
#include "planner.h"

#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "model/cell_cutter.h"

namespace phymul {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double tick_without_rate = 1e-3;  // s
constexpr int compared_times = 8;           // of a motion
/// Share of the way to the mean of its neighbours by which a point lies inside its particle: bodies of other spacings
/// then have it, too, where they round an edge off in another way.
constexpr double inward = 0.3;
/// Cells: a point near a rounded edge may lie outside a finer body by more than one of its small cells.
constexpr double most_outside = 20.0;
constexpr int warm_up_ticks = 3, fewest_ticks = 9, fewest_late_ticks = 3;
constexpr double enough_seconds = 0.05, most_seconds = 0.3;  // of measured ticks
constexpr int trial_steps = 8;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double median(std::vector<double>& values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

void require_constant_loads(Simulation& sim) {
  for (std::size_t row = 0; row < sim.scene().loads().size(); ++row) {
    const std::vector<ValueEvent>& events = sim.scene().loads()[row].events;
    if (events.empty() || !(events.back().date > sim.time())) continue;
    throw SceneError("load " + std::to_string(row) + " changes until " + to_decimal(events.back().date) +
                     " s, so the rest shape says little; give PlanOptions::probe_time");
  }
}

}  // namespace

Index own_particles(const Model& model) {
  return model.particle_count() - static_cast<Index>(spare_particles_of(model).size());
}

Prober::Prober(const SceneBuilder& builder, const PlanOptions& options)
    : builder_(builder), options_(options), begin_(Clock::now()) {}

double Prober::elapsed() const {
  return seconds_since(begin_);
}

double Prober::tick_length() const {
  return options_.rate > 0.0 ? 1.0 / options_.rate : tick_without_rate;
}

Simulation Prober::build(const PlanCandidate& candidate) const {
  Simulation sim = builder_(candidate);
  const Solver& solver = sim.solver();
  const std::string rule = "; the builder must pass PlanCandidate::options() to its Simulation";
  if (solver.name() != candidate.backend) {
    throw SceneError("expected a simulation with the backend \"" + candidate.backend + "\", got \"" +
                     std::string(solver.name()) + '"' + rule);
  }
  if (solver.options().threads != candidate.threads) {
    throw SceneError("expected a simulation with SolverOptions::threads " + std::to_string(candidate.threads) +
                     ", got " + std::to_string(solver.options().threads) + rule);
  }
  const double step = sim.step_limit() / solver.stable_step();
  if (std::isfinite(solver.stable_step()) && std::abs(step - candidate.step) > 1e-6) {
    throw SceneError("expected a simulation with SimulationOptions::step " + to_decimal(candidate.step) + ", got " +
                     to_decimal(step) + rule);
  }
  if (!probes_motion() && solver.options().sleep_tolerance) {
    throw SceneError(
        "a body at rest sleeps, so its ticks say nothing; plan without SolverOptions::sleep_tolerance, or give "
        "PlanOptions::probe_time");
  }
  return sim;
}

void Prober::choose_points(const Model& model) {
  if (std::ranges::none_of(model.cells, [](const Cell& cell) { return is_volume(cell.type); })) {
    throw SceneError("expected a body with volume cells, whose points can be compared, got none");
  }
  for (Index i = 0; i < own_particles(model); ++i) {
    Vec3 mean = Vec3::Zero();
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) mean += model.rest[*j];
    const Index count = model.neighbours.size(i);
    const Vec3 way = count > 0 ? Vec3(mean / count - model.rest[i]) : Vec3::Zero();
    points_.push_back(model.rest[i] + inward * way);
  }
  // Between its particles a body is less accurate than at them.
  for (const Cell& cell : model.cells) {
    if (!is_volume(cell.type) || cell.share == 0.0) continue;
    Vec3 centre = Vec3::Zero();
    for (const Index i : cell.particles) centre += model.rest[i] / static_cast<double>(cell.particles.size());
    points_.push_back(centre);
  }
}

VecList Prober::displacements(Simulation& sim, const Skin& skin) const {
  State state = sim.solver().read();
  for (std::size_t i = 0; i < state.position.size(); ++i) state.position[i] -= sim.model().rest[i];
  return skin.deform(state.position);
}

Probe Prober::probe(const PlanCandidate& candidate, const std::function<bool(const Probe&)>& is_known) {
  const Clock::time_point begin = Clock::now();
  Probe result;
  Simulation sim = build(candidate);
  const Model& model = sim.model();
  result.particles = own_particles(model);
  result.h = mean_spacing(model);
  if (is_known(result)) return result;
  if (points_.empty()) choose_points(model);
  const Skin skin(model, points_, most_outside);
  if (probes_motion()) {
    follow_motion(sim, &skin, result);
  } else {
    require_constant_loads(sim);
    find_rest(sim, result);
    if (result.failure.empty()) {
      result.u = displacements(sim, skin);
      result.rest = sim.state();
      measure_ticks(sim, result);
    }
  }
  if (!result.failure.empty()) result.u.clear();
  result.seconds = seconds_since(begin);
  return result;
}

Probe Prober::measure(const PlanCandidate& candidate, const Probe& known) {
  Simulation sim = build(candidate);
  Probe result;
  result.particles = known.particles;
  result.h = known.h;
  result.by_steps = known.by_steps;
  result.rest_seconds = known.rest_seconds;
  if (probes_motion()) {
    follow_motion(sim, nullptr, result);
    return result;
  }
  if (known.by_steps && options_.rest_in > 0.0) {
    rest_by_steps(sim, result);
  } else {
    sim.set_state(known.rest);
  }
  if (result.failure.empty()) measure_ticks(sim, result);
  return result;
}

void Prober::find_rest(Simulation& sim, Probe& probe) const {
  const Clock::time_point begin = Clock::now();
  StaticResult result;
  try {
    result = sim.solve_static();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::not_supported) throw;
    return rest_by_steps(sim, probe);
  }
  probe.rest_seconds = seconds_since(begin);
  // Without any evaluation: the scene of this body has no rest.
  if (result.status == RestStatus::failed && result.evaluations == 0) {
    probe.failure = result.cause;
    return;
  }
  if (!result.converged()) {
    probe.note = "solve_static: " + result.message();
    return rest_by_steps(sim, probe);
  }
  probe.folded = result.folded >= 0;
  if (probe.folded) probe.note = "cell " + std::to_string(result.folded) + " is flat or inside out";
}

void Prober::rest_by_steps(Simulation& sim, Probe& probe) const {
  probe.by_steps = true;
  Clock::time_point begin = Clock::now();
  if (const StepReport report = sim.advance(trial_steps * sim.step_limit()); !report.ok()) {
    probe.failure = report.message();
    return;
  }
  const double per_step = std::max(1e-9, seconds_since(begin) / trial_steps);
  const double most = std::min(1e6, std::max(0.0, left()) / per_step);
  begin = Clock::now();
  const RestResult rest = sim.run_to_rest(std::max(1, static_cast<int>(most)));
  probe.rest_seconds = seconds_since(begin);
  if (!rest.converged()) {
    probe.failure = rest.message();
  } else if (rest.folded >= 0) {
    probe.folded = true;
    probe.note = "cell " + std::to_string(rest.folded) + " is flat or inside out";
  }
}

/// s of wall time; a failure is said in the probe.
double Prober::timed_tick(Simulation& sim, Probe& probe) const {
  const Clock::time_point begin = Clock::now();
  const StepReport report = sim.advance(tick_length());
  if (!report.ok()) probe.failure = report.message();
  // Devices work on after the call; a tick ends when its result can be used.
  if (sim.solver().name() != "cpu" && sim.solver().name() != "reference") sim.solver().read();
  return seconds_since(begin);
}

void Prober::follow_motion(Simulation& sim, const Skin* skin, Probe& probe) const {
  const auto ticks = static_cast<int>(std::clamp(std::ceil(options_.probe_time / tick_length() - 1e-9), 1.0, 1e9));
  std::vector<double> seconds;
  int compared = 0;
  for (int tick = 1; tick <= ticks && probe.failure.empty(); ++tick) {
    if (options_.before_tick) options_.before_tick(sim);
    seconds.push_back(timed_tick(sim, probe));
    const bool is_compared =
        static_cast<std::int64_t>(tick) * compared_times >= static_cast<std::int64_t>(compared + 1) * ticks;
    if (skin && is_compared) {
      const VecList u = displacements(sim, *skin);
      probe.u.insert(probe.u.end(), u.begin(), u.end());
      compared = static_cast<int>(static_cast<std::int64_t>(tick) * compared_times / ticks);
    }
    if (left() < 0.0 && tick < ticks) {
      // Times are known all the same, though of the first part of the motion only.
      (skin ? probe.failure : probe.note) =
          "the budget ended at " + std::to_string(tick) + " of " + std::to_string(ticks) + " ticks";
      break;
    }
  }
  if (probe.failure.empty() || left() < 0.0) probe.tick = median(seconds);
}

void Prober::measure_ticks(Simulation& sim, Probe& probe) const {
  std::vector<double> seconds;
  double sum = 0.0;
  for (int k = 0; k < warm_up_ticks && probe.failure.empty() && (k == 0 || left() > 0.0); ++k) {
    sum += timed_tick(sim, probe);
  }
  // A slow body needs no long warm-up.
  const auto enough = [&] {
    const auto count = static_cast<int>(seconds.size());
    return (count >= fewest_ticks && sum >= enough_seconds) || (count >= fewest_late_ticks && sum >= most_seconds);
  };
  while (probe.failure.empty() && (seconds.empty() || (left() > 0.0 && !enough()))) {
    seconds.push_back(timed_tick(sim, probe));
    sum += seconds.back();
  }
  if (probe.failure.empty()) probe.tick = median(seconds);
}

}  // namespace phymul
