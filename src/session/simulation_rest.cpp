// SPDX-License-Identifier: MIT
//
// Rest by dynamic relaxation: motion dies out fastest when the slowest vibration is damped critically, at twice its
// angular frequency. That frequency follows from the motion itself, by Rayleigh's quotient of its change of shape
// (P. Underwood, "Dynamic relaxation", in Computational Methods for Transient Analysis, North-Holland 1983, 245-265).
#include <phymul/elasticity.h>
#include <phymul/load_frame.h>
#include <phymul/model.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "elastic/dissipation.h"
#include "interaction/joint_set.h"
#include "simulation_parts.h"

namespace phymul {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int fewest_steps = 16;  // between two estimates
/// By how much an estimate may differ from the one before: a body that falls shows no stiffness, and rounding a lot.
constexpr double most_down = 0.25, most_up = 2.0;

/// The waves that cross one spacing in the shortest vibration take this frequency to cross the body, rad/s.
double first_guess(const Model& model, const Solver& solver, double dt) {
  // The stable step of an undamped body, solved for omega_max: largest_step() (elastic/dissipation.h).
  const StepBound bound = step_bound(solver.topology(), Spectrum{.largest = 1.0});
  const double step = solver.stable_step();
  const double shortest = std::sqrt(4.0 / (step * (bound.stiffness * step + 2.0 * bound.damping)));
  const double guess = 0.5 * shortest * mean_spacing(model) / body_size(model);
  return guess > 0.0 && std::isfinite(guess) ? guess : 0.01 / dt;
}

/// For the stiffness of joints without their dampers.
State without_motion(State state) {
  for (Vec3& velocity : state.velocity) velocity.setZero();
  return state;
}

/// Rayleigh's quotient of the free coordinates' way from one state to another, 1/s^2. Not above 0, or not a number:
/// the way says nothing of a vibration.
double squared_frequency(const TopologyTextures& topology, const Scene& scene, const State& from, const State& to) {
  LoadFrame loads;
  scene.prepare(loads);
  VecList before(from.position.size()), after(to.position.size());
  elastic_forces(topology, from.position, before);
  elastic_forces(topology, to.position, after);
  if (!scene.joints().empty()) {
    add_joint_forces(scene, without_motion(from), before);
    add_joint_forces(scene, without_motion(to), after);
  }
  double work = 0.0, inertia = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!loads.fixed.empty() && (loads.fixed[i] >> axis & 1)) continue;
      const double way = to.position[i][axis] - from.position[i][axis];
      work -= way * (after[i][axis] - before[i][axis]);
      inertia += topology.mass[i] * way * way;
    }
  }
  return work / inertia;
}

}  // namespace

bool Simulation::Parts::Progress::is_due() const {
  return tell && std::chrono::duration<double>(Clock::now() - told).count() >= seconds;
}

bool Simulation::Parts::Progress::pass_on(StepProgress part) {
  part.steps += steps_before;
  if (of > 0) part.of = of;
  const bool goes_on = tell(part);
  told = Clock::now();
  return goes_on;
}

RestResult Simulation::Parts::run_to_rest(int max_steps, double dt) {
  double frequency = first_guess(model, solver(), dt);
  progress.told = Clock::now();
  progress.of = max_steps;
  struct AtReturn {  // also where the user's function throws
    Progress& whole;
    ~AtReturn() { whole.steps_before = whole.of = 0; }
  } const at_return{progress};
  State from = solver().read(), to;
  RestResult result;
  int steps = 0;
  while (true) {
    const int some = static_cast<int>(std::clamp(1.0 / (frequency * dt), 1.0 * fewest_steps, 1e6));
    Damping critical{.rate = 2.0 * frequency};
    progress.steps_before = steps;
    // Tools strain a body most, and where half of the stable step is too long it never rests. Stiffening bodies, whose
    // frequencies rise most, may need less without tools.
    const bool stiffens = elastic().options.strain_energy == StrainEnergy::stiffening;
    if (!options.step && (stiffens || !scene.tools().empty())) dt = step_limit(std::numeric_limits<double>::infinity());
    const StepReport before = result.report;
    const auto go_on = [&] { return run_to_rest(std::min(some, max_steps - steps), dt, critical); };
    result = go_on();
    // With substeps a step that is damped more must be shorter.
    while (result.report.status == StepStatus::unstable_step && result.report.steps == 0 &&
           dt <= solver().stable_step() && critical.rate * dt > 1e-3) {
      critical.rate *= 0.5;
      result = go_on();
    }
    result.report.force_clamped |= before.force_clamped;
    result.report.springs_broken += before.springs_broken;
    result.report.tissue_gave_way += before.tissue_gave_way;
    result.report.uncut += before.uncut;
    result.report.torn += before.torn;
    steps += result.report.steps;
    if (result.status != RestStatus::step_limit || steps >= max_steps) break;
    solver().read(to);
    const double measured = std::sqrt(squared_frequency(elastic(), scene, from, to));
    if (measured > 0.0) frequency = std::clamp(measured, most_down * frequency, most_up * frequency);
    std::swap(from, to);
    if (!progress.is_due()) continue;
    progress.steps_before = 0;
    const StepReport& report = result.report;
    if (!progress.pass_on({steps, max_steps, report.time, report.residual, report.max_speed})) {
      result.status = RestStatus::stopped;
      result.report.stopped = true;
      break;
    }
  }
  result.report.steps = steps;
  return result;
}

}  // namespace phymul
