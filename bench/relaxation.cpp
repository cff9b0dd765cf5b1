// SPDX-License-Identifier: MIT
#include "relaxation.h"

#include <phymul/error.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

namespace phymul::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

const char* name_of(StepStatus status) {
  switch (status) {
    case StepStatus::ok:
      return "ok";
    case StepStatus::invalid_step:
      return "invalid_step";
    case StepStatus::unstable_step:
      return "unstable_step";
    case StepStatus::not_finite:
      return "not_finite";
    case StepStatus::device_lost:
      return "device_lost";
  }
  return "unknown";
}

struct Excited {
  double omega = 0.0;  ///< rad/s, of the motion the load excites; 0: nothing moved
  double reach = 0.0;  ///< m, largest displacement met
};

class Relaxing {
 public:
  Relaxing(std::shared_ptr<const TopologyTextures> topology, const Scene& scene, const RelaxationPlan& plan)
      : topology_(std::move(topology)), scene_(scene), plan_(plan) {
    options_.on_unstable = UnstableStep::allow;
    options_.spectrum = estimate_spectrum(*topology_, topology_->rest);
    result_.stable_step = stable_step(*options_.spectrum, 1.0);
    result_.dt = plan.step_share * result_.stable_step;
  }

  Relaxation run(const VecList& start) {
    State state = rest_state(scene_.model());
    state.position = start;
    began_ = Clock::now();
    const Excited excited = excite(state);
    if (!result_.status.empty()) return result_;
    result_.rate = 2.0 * excited.omega;
    options_.damping.rate = result_.rate;
    // At critical damping a body that has `left` to go moves at about omega times that.
    const double omega_max = std::sqrt(options_.spectrum->largest);
    const double left = plan_.rest_accuracy * excited.reach;
    options_.rest_tolerance = std::max(left * excited.omega / (omega_max * mean_spacing(scene_.model())), 1e-14);
    settle(state);
    return result_;
  }

 private:
  std::unique_ptr<Solver> solver() const { return make_solver(plan_.backend, topology_, scene_, options_); }

  bool failed(const StepReport& report) {
    if (report.ok()) return false;
    result_.status = name_of(report.status);
    result_.message = report.message();
    return true;
  }

  Excited excite(const State& start) {
    Excited excited;
    const auto undamped = solver();
    undamped->reset(start);
    result_.device = undamped->device();
    State state;
    double peak = 0.0, peak_time = 0.0;
    for (int steps = 0;;) {
      const int batch = std::max(4, steps / 12);
      if (failed(undamped->step(batch, result_.dt))) return excited;
      steps += batch;
      undamped->read(state);
      result_.state = state;
      excited.reach = std::max(excited.reach, displacement_norms(scene_.model(), state).max);
      const double kinetic = kinetic_energy(scene_.model(), state);
      if (kinetic > peak) peak = kinetic, peak_time = state.time;
      if (kinetic < 0.8 * peak || peak == 0.0) break;
      if (seconds_since(began_) > 0.4 * plan_.wall_cap) {
        result_.status = "over_budget";
        result_.message = "the first quarter of the period is not over after " + std::to_string(steps) + " steps";
        result_.steps = steps;
        return excited;
      }
    }
    excited.omega = peak_time > 0.0 ? std::numbers::pi / 2.0 / peak_time : 0.0;
    return excited;
  }

  void settle(const State& start) {
    const auto damped = solver();
    damped->reset(start);
    std::vector<double> per_step;
    result_.status = "over_budget";
    result_.message = "not at rest within the time given";
    const double most_steps = std::max(500.0, 2.0 * plan_.patience / (result_.rate * result_.dt));
    while (seconds_since(began_) < plan_.wall_cap) {
      const int batch = std::max(8, result_.steps / 16);
      const auto start_of_batch = Clock::now();
      const StepReport report = damped->run_to_rest(batch, result_.dt);
      const double wall = seconds_since(start_of_batch);
      if (report.steps > 0) per_step.push_back(wall / report.steps);
      result_.steps += report.steps;
      if (failed(report)) break;
      if (report.at_rest) {
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
    if (!per_step.empty()) {
      const auto middle = per_step.begin() + static_cast<std::ptrdiff_t>(per_step.size() / 2);
      std::ranges::nth_element(per_step, middle);
      result_.wall_per_step = *middle;
    }
  }

  std::shared_ptr<const TopologyTextures> topology_;
  const Scene& scene_;
  RelaxationPlan plan_;
  SolverOptions options_;
  Relaxation result_;
  Clock::time_point began_;
};

}  // namespace

Relaxation relax(std::shared_ptr<const TopologyTextures> topology, const Scene& scene, const VecList& start,
                 const RelaxationPlan& plan) {
  try {
    return Relaxing(std::move(topology), scene, plan).run(start);
  } catch (const Error& error) {
    Relaxation refused;
    refused.status = "refused";
    refused.message = error.what();
    return refused;
  }
}

}  // namespace phymul::bench
