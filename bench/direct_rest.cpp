// SPDX-License-Identifier: MIT
#include "direct_rest.h"

#include <phymul/error.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "stopwatch.h"

namespace phymul::bench {
namespace {

Relaxation solved(const Problem& problem, const MethodBody& body, const VecList& start, const RelaxationPlan& plan,
                  int repeats) {
  SimulationOptions options{.backend = plan.backend, .topology = body.options};
  options.solver.on_unstable = UnstableStep::allow;
  Relaxation result;
  std::vector<double> seconds;
  std::optional<Simulation> sim;  // anew for each call, which would keep the grids of the one before
  const Stopwatch began;
  do {
    sim.emplace(body.model, options);
    problem.load(sim->scene());
    State state = rest_state(sim->model());
    state.position = start;
    sim->set_state(state);
    const Stopwatch begin;
    const StaticResult rest = sim->solve_static({.tolerance = plan.rest_accuracy});
    seconds.push_back(begin.seconds());
    result.steps = rest.evaluations;
    result.status = rest.converged() ? "ok" : rest.status == RestStatus::failed ? "no_rest" : "over_budget";
    result.message = rest.converged() ? std::string() : rest.message();
  } while (result.status == "ok" && static_cast<int>(seconds.size()) < repeats && began.seconds() < plan.wall_cap);
  result.device = sim->solver().device();
  result.wall_per_step = median(std::move(seconds)) / std::max(1, result.steps);
  result.state = sim->state();
  for (const Problem::NamedTool& named : problem.tools) {
    result.tool_force[named.name] = sim->force_on(sim->scene().tool(named.name)).force;
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
