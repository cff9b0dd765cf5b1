// SPDX-License-Identifier: MIT
//
// States of a simulation: started from, taken as snapshots and gone back to.
#include <phymul/backend.h>
#include <phymul/error.h>
#include <phymul/simulation.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/files.h"
#include "elastic/dissipation.h"
#include "simulation_parts.h"
#include "solver/half_step.h"

namespace phymul {

bool Simulation::Parts::is_at_start(const Snapshot& now) const {
  if (!started) return false;
  const State& taken = started->taken;
  return now.last_dt == 0.0 && now.state.time == taken.time && now.state.position == taken.position &&
         now.state.velocity == taken.velocity;
}

Snapshot Simulation::Parts::snapshot() {
  Snapshot now = solver().snapshot();
  if (is_at_start(now)) now.start = {started->wanted.position, started->wanted.velocity, started->dt};
  now.start.cut_later = waiting;
  return now;
}

void Simulation::Parts::begin_again(const Snapshot& there) {
  started.reset();
  last_dt = there.last_dt;
  if (!there.start.position.empty()) {
    started = Start{.wanted = there.state, .taken = solver().read(), .dt = there.start.dt};
    started->wanted.position = there.start.position;
    started->wanted.velocity = there.start.velocity;
  }
  waiting = there.start.cut_later;
  std::erase_if(waiting, [&](const Snapshot::CutLater& own) {  // of another body
    return own.cell >= static_cast<Index>(model.cells.size()) ||
           model.cells[own.cell].particles.size() > own.cut.size();
  });
  state_changed();
  begin_history_anew();
}

void Simulation::Parts::follow_history(const StepReport& report) {
  if (history)
    history->follow(solver(), report, report.steps == 0 ? snapshot().start : Snapshot::Start{.cut_later = waiting});
}

void Simulation::Parts::start(const State& state) {
  const double dt = step_limit();
  solver().start(state, dt);
  last_dt = 0.0;
  started = Start{.wanted = state, .taken = solver().read(), .dt = dt};
  state_changed();
  begin_history_anew();
}

void Simulation::Parts::start_at_rest(const State& state, const std::vector<ToolForce>& of_tools,
                                      const std::vector<JointReport>& of_joints) {
  solver().reset(state);
  Snapshot rest = solver().snapshot();
  for (std::size_t row = 0; row < std::min(rest.tools.size(), of_tools.size()); ++row) {
    ToolForce& force = rest.tools[row].force;  // what it holds is known
    force.force = force.mean_force = of_tools[row].force;
    force.torque = force.mean_torque = of_tools[row].torque;
    force.particles = of_tools[row].particles;
  }
  if (rest.joints.size() == of_joints.size()) rest.joints = of_joints;
  solver().restore(rest);
  last_dt = 0.0;
  started = Start{.wanted = state, .taken = solver().read(), .dt = step_limit()};
  state_changed();
  begin_history_anew();
}

void Simulation::Parts::bring_back(const Snapshot& snapshot) {
  if (snapshot.topology_hash != 0) {
    if (snapshot.topology_hash != fingerprint(*topology, snapshot.removed_cells, snapshot.cuts)) return;
    set_body(snapshot.removed_cells, snapshot.cuts);
  }
  if (!snapshot.scene) return;
  const auto& tools = snapshot.scene->tools;
  scene.bring_back(*snapshot.scene);
  for (std::size_t row = 0; row < std::min(tools.size(), snapshot.tools.size()); ++row) {
    scene.tool(tools[row].first).move_to(snapshot.tools[row].target);
  }
}

void Simulation::Parts::take_back(const Snapshot& before, const std::vector<SceneTool>& asked) {
  bring_back(before);
  solver().restore(before);
  const std::map<std::uint64_t, SeenTool> seen = tools_seen;
  see_tools();
  ask_tools_again(asked, seen);
  waiting = before.start.cut_later;
}

void Simulation::Parts::begin(double dt) {
  solver();
  if (!started || !(dt > 0.0) || !std::isfinite(dt)) return;
  // What the solver refuses begins nothing.
  if (options.solver.on_unstable == UnstableStep::refuse && dt > 2.0 * solver().stable_step()) return;
  if (started->dt == dt) return;
  Snapshot now = solver().snapshot();
  if (!is_at_start(now)) return;
  const std::map<std::uint64_t, SeenTool> seen = tools_seen;
  now.state.position = started->wanted.position;
  now.state.velocity = started->wanted.velocity;
  solver().start(now.state, dt);  // the rest as it is by now: volumes and threads may have changed since
  started->taken = solver().read();
  started->dt = dt;
  state_changed();
  ask_tools_again(scene.tools(), seen);
}

void Simulation::Parts::state_changed() {
  see_tools();
  blades_seen.clear();
  for (const SceneTool& tool : scene.tools()) {
    if (std::holds_alternative<Blade>(tool.tool.shape))
      blades_seen[tool.id] = {solver().tool_pose(tool.name), tool.places};
  }
  if (recorder) recorder->restore(snapshot());
}

/// States from this time on are of a past that led elsewhere.
void Simulation::Parts::begin_history_anew() {
  if (!history) return;
  const Snapshot now = snapshot();
  StepReport anew;
  anew.time = std::nextafter(now.state.time, -HUGE_VAL);
  anew.steps = history_every;
  history->follow(solver(), anew, now.start);
}

State Simulation::state() const {
  Snapshot now = solver().snapshot();
  State& state = now.state;
  if (parts_->is_at_start(now)) {
    state.velocity = parts_->started->wanted.velocity;
  } else if (now.last_dt > 0.0) {
    const double d = solver().options().damping.factor_at(now.last_dt);
    const TopologyTextures& elastic = parts_->elastic();
    const StrainMemory strains = strains_of(now, *parts_->topology);
    const auto* backend = dynamic_cast<const SolverBackend*>(&solver());
    VecList further = dissipation_at(elastic, state.position, strains, now.last_dt).force;
    const std::vector<ToolState> tools = state.tools;
    if (backend != nullptr) {
      further = backend->substep_forces(state, now.last_dt, std::move(further));
      backend->set_last_velocities(state.tools, now.last_dt);
    }
    to_own_time(elastic, parts_->scene, {now.last_dt, d}, state, further);
    state.tools = tools;
  }
  return std::move(state);
}

void Simulation::set_state(const State& state) {
  parts_->start(state);
}

Snapshot Simulation::snapshot() const {
  return parts_->snapshot();
}

void Simulation::restore(const Snapshot& snapshot) {
  const Snapshot before = parts_->snapshot();
  const std::vector<SceneTool> asked = scene().tools();
  try {
    parts_->bring_back(snapshot);
    parts_->solver().restore(snapshot);
  } catch (...) {
    parts_->take_back(before, asked);
    throw;
  }
  parts_->begin_again(snapshot);
}

void Simulation::save(const std::string& path) const {
  save_state(snapshot(), path);
}

void Simulation::load(const std::string& path) {
  const Snapshot snapshot = read_state(path);
  try {
    restore(snapshot);
  } catch (const Error& error) {
    throw in_file(path, with_prefix(path + ": ", error));
  }
}

void Simulation::keep_history(int every, std::size_t most_bytes) {
  parts_->history.emplace(StateHistory(every, most_bytes));  // which may throw: then the old one stays
  parts_->history_every = every;
  parts_->step(0, step_limit());
}

bool Simulation::rewind(double time) {
  const Snapshot* const found = parts_->history ? parts_->history->newest_at(time) : nullptr;
  if (found == nullptr) return false;
  restore(Snapshot(*found));
  return true;
}

}  // namespace phymul
