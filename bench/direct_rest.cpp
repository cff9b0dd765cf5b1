// SPDX-License-Identifier: MIT
#include "direct_rest.h"

#include <phymul/error.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace phymul::bench {
namespace {

Relaxation solved(const Problem& problem, const MethodBody& body, const VecList& start, const RelaxationPlan& plan,
                  int repeats) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  SimulationOptions options{.backend = plan.backend, .topology = body.options};
  options.solver.on_unstable = UnstableStep::allow;
  Simulation sim(body.model, options);
  problem.load(sim.scene());
  State state = rest_state(sim.model());
  state.position = start;
  Relaxation result;
  result.device = sim.solver().device();
  std::vector<double> seconds;
  const Clock::time_point began = Clock::now();
  do {
    sim.set_state(state);
    const Clock::time_point begin = Clock::now();
    const StaticResult rest = sim.solve_static({.tolerance = plan.rest_accuracy});
    seconds.push_back(seconds_since(begin));
    result.steps = rest.evaluations;
    result.status = rest.converged() ? "ok" : rest.status == RestStatus::failed ? "no_rest" : "over_budget";
    result.message = rest.converged() ? std::string() : rest.message();
  } while (result.status == "ok" && static_cast<int>(seconds.size()) < repeats && seconds_since(began) < plan.wall_cap);
  const auto middle = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::ranges::nth_element(seconds, middle);
  result.wall_per_step = *middle / std::max(1, result.steps);
  result.state = sim.state();
  for (const Problem::NamedTool& named : problem.tools) {
    result.tool_force[named.name] = sim.force_on(sim.scene().tool(named.name)).force;
  }
  return result;
}

}  // namespace

Relaxation solve_directly(const Problem& problem, const MethodBody& body, const VecList& start,
                          const RelaxationPlan& plan, int repeats) {
  try {
    return solved(problem, body, start, plan, repeats);
  } catch (const Error& error) {
    return refused(error);
  }
}

}  // namespace phymul::bench
