// SPDX-License-Identifier: MIT
#include "relaxation.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "stopwatch.h"

namespace phymul::bench {
namespace {

/// Rayleigh quotient of the motion from one state to another, 1/s^2: how stiff the body is against it, over its mass.
/// Negative or not finite for bodies without an energy.
double stiffness_over_mass(const TopologyTextures& topology, const VecList& from, const VecList& to) {
  VecList before(from.size()), after(from.size());
  elastic_forces(topology, from, before);
  elastic_forces(topology, to, after);
  double stiff = 0.0, mass = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3 move = to[i] - from[i];
    stiff += move.dot(before[i] - after[i]);
    mass += topology.mass[i] * move.squaredNorm();
  }
  return stiff / mass;
}

constexpr std::size_t timed_runs = 5;

class Relaxing {
 public:
  Relaxing(std::shared_ptr<const TopologyTextures> topology, const Scene& scene, const RelaxationPlan& plan)
      : topology_(std::move(topology)), scene_(scene), plan_(plan) {
    options_.on_unstable = UnstableStep::allow;
    options_.threads = plan.threads;
    options_.spectrum = estimate_spectrum(*topology_, topology_->rest);
    result_.stable_step = stable_step(*options_.spectrum, 1.0);
    result_.dt = plan.step_share * result_.stable_step;
  }

  Relaxation run(const VecList& start) {
    State state = rest_state(scene_.model());
    state.position = start;
    began_ = {};
    result_.excited = plan_.excited;
    if (result_.excited.omega == 0.0) result_.excited = find_excited(state);
    if (!result_.status.empty()) return result_;
    const auto& [omega, reach] = result_.excited;
    result_.rate = 2.0 * omega;
    options_.damping.rate = result_.rate;
    // At critical damping a body that has `left` to go moves at about omega times that.
    const double omega_max = std::sqrt(options_.spectrum->largest);
    const double left = plan_.rest_accuracy * reach;
    options_.rest_tolerance = std::max(left * omega / (omega_max * mean_spacing(scene_.model())), 1e-14);
    settle(state);
    return result_;
  }

 private:
  std::unique_ptr<Solver> solver() const { return make_solver(plan_.backend, topology_, scene_, options_); }

  bool failed(const StepReport& report) {
    if (report.ok()) return false;
    result_.message = report.message();
    result_.status = result_.message.substr(0, result_.message.find(':'));
    return true;
  }

  bool over_budget(double share, const char* stage) {
    if (began_.seconds() < share * plan_.wall_cap) return false;
    result_.status = "over_budget";
    result_.message = stage;
    return true;
  }

  Excited find_excited(const State& start) {
    Excited excited = first_peak(start);
    State state = start;
    for (int round = 0; round < 3 && result_.status.empty() && excited.omega > 0.0; ++round) {
      const double slower = slow_omega(excited.omega, state);
      if (!(slower > 0.0) || slower > 0.8 * excited.omega) break;
      excited.omega = std::max(slower, 0.05 * excited.omega);
    }
    return excited;
  }

  Excited first_peak(const State& start) {
    Excited excited;
    const auto undamped = solver();
    undamped->reset(start);
    result_.device = undamped->device();
    double peak = 0.0, peak_time = 0.0;
    for (int steps = 0; !over_budget(0.3, "the first quarter of the period is not over");) {
      const int batch = std::max(4, steps / 12);
      if (failed(undamped->step(batch, result_.dt))) return excited;
      steps += batch;
      const State& state = result_.state = undamped->read();
      excited.reach = std::max(excited.reach, displacement_norms(scene_.model(), state).max);
      const double kinetic = kinetic_energy(scene_.model(), state);
      if (kinetic > peak) peak = kinetic, peak_time = state.time;
      if (kinetic < 0.8 * peak || peak == 0.0) break;
    }
    excited.omega = peak_time > 0.0 ? std::numbers::pi / 2.0 / peak_time : 0.0;
    return excited;
  }

  /// Goes on from `state`, critically damped for omega; 0 where what still moves has no frequency.
  double slow_omega(double omega, State& state) {
    options_.damping.rate = 2.0 * omega;
    const auto damped = solver();
    damped->reset(state);
    const int steps = static_cast<int>(std::ceil(4.0 / (omega * result_.dt)));
    if (failed(damped->step(steps, result_.dt)) || over_budget(0.5, "its slow motion is not found")) return 0.0;
    const VecList before = damped->read().position;
    if (failed(damped->step(steps / 2 + 1, result_.dt))) return 0.0;
    damped->read(state);
    result_.state = state;
    const double square = stiffness_over_mass(*topology_, before, state.position);
    return square > 0.0 && std::isfinite(square) ? std::sqrt(square) : 0.0;
  }

  void settle(const State& start) {
    const auto damped = solver();
    damped->reset(start);
    result_.device = damped->device();
    result_.status = "over_budget";
    result_.message = "not at rest within the time given";
    const double most_steps = std::max(500.0, 2.0 * plan_.patience / (result_.rate * result_.dt));
    while (began_.seconds() < plan_.wall_cap) {
      const RestResult rest = damped->run_to_rest(std::max(8, result_.steps / 16), result_.dt);
      result_.steps += rest.report.steps;
      if (failed(rest.report)) break;
      if (rest.converged()) {
        result_.status = "ok";
        result_.message.clear();
        break;
      }
      if (result_.steps > most_steps) {
        result_.status = "restless";
        result_.message = "still moving after five times the steps that critical damping takes";
        break;
      }
    }
    damped->read(result_.state);
    for (const SceneTool& tool : scene_.tools()) {
      result_.tool_force[tool.name] = damped->tool_force(tool.name).mean_force;
    }
    time_steps(*damped, start);
  }

  /// The same steps again, in calls of step() alone: the calls above also look for cells that are folded.
  void time_steps(Solver& solver, const State& start) {
    std::vector<double> seconds, processor;
    const int steps = std::max(1, result_.steps);
    const Stopwatch began;
    do {
      solver.reset(start);
      const double processor_begin = processor_seconds();
      const Stopwatch begin;
      const int taken = std::max(1, solver.step(steps, result_.dt).steps);
      seconds.push_back(begin.seconds() / taken);
      processor.push_back((processor_seconds() - processor_begin) / taken);
    } while (seconds.size() < timed_runs && result_.status == "ok" && began.seconds() < 0.5 * plan_.wall_cap);
    result_.wall_per_step = median(std::move(seconds));
    result_.cpu_per_step = median(std::move(processor));
  }

  std::shared_ptr<const TopologyTextures> topology_;
  const Scene& scene_;
  RelaxationPlan plan_;
  SolverOptions options_;
  Relaxation result_;
  Stopwatch began_;
};

}  // namespace

Relaxation refused(const Error& error) {
  Relaxation relaxation;
  relaxation.status = "refused";
  relaxation.message = error.what();
  return relaxation;
}

Relaxation relax(std::shared_ptr<const TopologyTextures> topology, const Scene& scene, const VecList& start,
                 const RelaxationPlan& plan) {
  try {
    return Relaxing(std::move(topology), scene, plan).run(start);
  } catch (const Error& error) {
    return refused(error);
  }
}

}  // namespace phymul::bench
