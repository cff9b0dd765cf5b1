// SPDX-License-Identifier: MIT
#include <phymul/bodies.h>
#include <phymul/error.h>
#include <phymul/monitor.h>
#include <phymul/simulation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "base/decimal.h"
#include "scene_bytes.h"
#include "simulation_parts.h"
#include "solver/solver_input.h"
#include "wire_codes.h"

namespace phymul {
namespace {

/// s, of a body that has no stiffness and so no step limit of its own.
constexpr double step_without_stiffness = 1e-3;
/// Share of a step that is rounding of the quotient of two times.
constexpr double rounding = 1e-9;
/// Up to so many steps in a call one more or less changes their length by much. Lengths that change to and fro drive
/// the fastest vibrations, against their damping.
constexpr double few_steps = 8.0;
/// Of the limit, that steps may grow to; and of that at rest, above which the body is nearly at rest.
constexpr double clearly_short = 0.8, nearly_at_rest = 0.98;

bool is_given(const Material& material) {
  return material != Material{};
}

Model with_materials(Model model, const SimulationOptions& options) {
  if (is_given(options.material)) set_material(model, options.material);
  for (const auto& [group, material] : options.materials) set_material(model, material, group);
  return model;
}

/// Each body gets its own material, or else the one of the options.
Model merged(std::vector<SimulationBody> bodies, SimulationOptions& options) {
  std::vector<NamedBody> named;
  for (SimulationBody& body : bodies) {
    const Material& material = is_given(body.material) ? body.material : options.material;
    if (is_given(material)) set_material(body.model, material);
    named.push_back({body.name, &body.model});
  }
  options.material = {};
  return merge_models(named);
}

}  // namespace

Simulation::Parts::Parts(Model model_in, SimulationOptions options_in)
    : options(std::move(options_in)), model(with_materials(std::move(model_in), options)), scene(model) {
  if (options.step && (!(*options.step > 0.0) || !std::isfinite(*options.step))) {
    throw Error("SimulationOptions::step must be finite and above 0; got " + to_decimal(*options.step));
  }
  if (options.tick_budget < 0) {
    throw Error("SimulationOptions::tick_budget must be 0 or more cells; got " + std::to_string(options.tick_budget));
  }
  if (options.runner) options.topology.runner = options.solver.runner = options.runner;
  if (options.damping.rate != 0.0 || options.damping.factor != 1.0) options.solver.damping = options.damping;
  require_options(options.solver);
  if (options.solver.progress) {
    progress.tell =
        std::exchange(options.solver.progress, [this](const StepProgress& at) { return progress.pass_on(at); });
    progress.seconds = options.solver.progress_seconds;
  }
  topology = std::make_shared<TopologyTextures>(build_topology(model, options.topology));
}

Solver& Simulation::Parts::solver() {
  if (!made) {
    warnings = warnings_of(model, scene, topology->options.law != Law::springs);
    made = options.make_solver ? options.make_solver(topology, scene, options.solver)
                               : phymul::make_solver(options.backend, topology, scene, options.solver);
    if (!made) throw Error("SimulationOptions::make_solver returned no solver");
    // Nothing is converted yet: the solver is at rest, and its first steps are not known.
    started = Start{.wanted = made->read(), .taken = made->read()};
    warnings.insert(warnings.end(), topology->notes.begin(), topology->notes.end());
    if (options.solver.sleep_tolerance) {
      const bool has_material = !topology->domains.empty(), dissipates = !topology->dissipation.empty();
      const bool walls = !topology->walls.empty();
      if (made->name() != "cpu" || !has_material || dissipates || walls) {
        warnings.emplace_back(
            "SolverOptions::sleep_tolerance has no effect: only the backend \"cpu\" has sleep, and only bodies without "
            "walls and with a material that does not dissipate; this is the backend \"" +
            std::string(made->name()) + "\"" +
            (walls           ? " and a body with walls"
             : !has_material ? " and a body without a material"
             : dissipates    ? " and a body with a retardation_time or relaxation_strength"
                             : ""));
      }
    }
    if (options.log) std::ranges::for_each(warnings, options.log);
  }
  return *made;
}

double Simulation::Parts::step_limit(double seconds) {
  const double limit = options.step ? *options.step * solver().stable_step() : solver().suggested_step(seconds);
  return std::isfinite(limit) ? limit : step_without_stiffness;
}

double Simulation::Parts::held_steps(double seconds, double limit, double steps) {
  if (options.step || !(last_dt > 0.0)) return steps;
  const double last = std::round(seconds / last_dt);
  const bool same_call = std::abs(last * last_dt - seconds) < 1e-6 * seconds;
  if (!same_call || !(last > steps) || last > few_steps) return steps;
  if (!growth_at_rest) growth_at_rest = frequency_growth(*topology, topology->rest);
  const double limit_at_rest = 0.9 / std::sqrt(*growth_at_rest) * solver().stable_step();  // Solver::suggested_step()
  if (!(limit < nearly_at_rest * limit_at_rest)) return steps;
  return std::clamp(std::ceil(seconds / (clearly_short * limit) - rounding), steps, last);
}

StepReport Simulation::Parts::step(int n, double dt) {
  StepReport report = recorder ? recorder->step(n, dt) : solver().step(n, dt);
  took_steps(report);
  divide(report);
  follow_history(report);
  return report;
}

bool Simulation::Parts::divide(StepReport& report) {
  const std::size_t before = topology->cuts.size();
  const auto is_blade = [](const SceneTool& tool) { return std::holds_alternative<Blade>(tool.tool.shape); };
  // Now, so that no step of a loop has to.
  if (report.ok() && report.steps == 0 && (!scene.tearing().empty() || std::ranges::any_of(scene.tools(), is_blade))) {
    body_edit();
  }
  if (report.ok()) cut_with_blades(report);
  report.cut_later = static_cast<int>(waiting.size());
  if (report.ok()) tear(report);
  const bool goes_on = topology->cuts.size() != before || !waiting.empty();
  if (goes_on) report.at_rest = false;  // that was said of what was whole
  return goes_on;
}

RestResult Simulation::Parts::run_to_rest(int max_steps, double dt, const Damping& damping) {
  RestResult result =
      recorder ? recorder->run_to_rest(max_steps, dt, damping) : solver().run_to_rest(max_steps, dt, damping);
  took_steps(result.report);
  if (divide(result.report) && result.converged()) result.status = RestStatus::step_limit;
  follow_history(result.report);
  return result;
}

Simulation::Simulation(Model model, SimulationOptions options)
    : parts_(std::make_unique<Parts>(std::move(model), std::move(options))) {}

Simulation::Simulation(std::vector<SimulationBody> bodies, SimulationOptions options) {
  Model model = merged(std::move(bodies), options);
  parts_ = std::make_unique<Parts>(std::move(model), std::move(options));
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const Model& Simulation::model() const {
  return parts_->model;
}
Scene& Simulation::scene() {
  return parts_->scene;
}
const Scene& Simulation::scene() const {
  return parts_->scene;
}
Solver& Simulation::unrecorded_solver() {
  return parts_->solver();
}
const Solver& Simulation::solver() const {
  return parts_->solver();
}

const std::vector<std::string>& Simulation::warnings() const {
  parts_->solver();
  return parts_->warnings;
}

double Simulation::step_limit(double seconds) const {
  return parts_->step_limit(seconds);
}

StepReport Simulation::advance(double seconds) {
  const double limit = step_limit(seconds);
  if (seconds == 0.0) return parts_->step(0, limit);
  const double steps = parts_->held_steps(seconds, limit, std::max(1.0, std::ceil(seconds / limit - rounding)));
  // One step of a length that makes no sense: the solver refuses it and says why.
  if (!(seconds > 0.0) || !(steps <= std::numeric_limits<int>::max())) return parts_->step(1, seconds);
  const double dt = seconds / steps;
  parts_->begin(dt);
  return parts_->step(static_cast<int>(steps), dt);
}

StepReport Simulation::step(int n, double dt) {
  if (n > 0) parts_->begin(dt);
  return parts_->step(n, dt);
}

RestResult Simulation::run_to_rest(int max_steps) {
  const double dt = step_limit(std::numeric_limits<double>::infinity());
  parts_->begin(dt);
  const Damping& damping = solver().options().damping;
  if (damping.rate > 0.0 || damping.factor < 1.0) return parts_->run_to_rest(max_steps, dt, damping);
  return parts_->run_to_rest(max_steps, dt);
}

double Simulation::time() const {
  return solver().time();
}

double Simulation::max_displacement() const {
  return displacement_norms(model(), solver().read()).max;
}

Energy Simulation::energy() const {
  return solver().energy();
}

const ToolForce& Simulation::force_on(const ToolHandle& tool) const {
  return solver().tool_force(tool);
}

const ToolPose& Simulation::pose_of(const ToolHandle& tool) const {
  return solver().tool_pose(tool);
}

const JointReport& Simulation::report_of(const JointHandle& joint) const {
  return solver().joint_report(joint);
}

void Simulation::record() {
  parts_->recorder.reset();
  parts_->recorder.emplace(parts_->solver(), scene());
}

const Recording& Simulation::recording() const {
  if (!parts_->recorder) throw Error("Simulation::recording: expected a call of record() before");
  const std::vector<Input>& inputs = parts_->recorder->recording().inputs;
  const bool is_known = !inputs.empty() && inputs.back().kind == input_kind::later;
  if (!parts_->waiting.empty() && !is_known) {  // which a replay cannot find out: it makes the recorded cuts
    Snapshot waiting;
    waiting.start.cut_later = parts_->waiting;
    ByteWriter out;
    put_snapshot(out, waiting);
    parts_->recorder->record(input_kind::later, out.bytes());
  }
  return parts_->recorder->recording();
}

void Simulation::replay(Recording recording) {
  const Snapshot& start = recording.start;
  const Snapshot before = parts_->snapshot();
  const std::vector<SceneTool> asked = scene().tools();
  const std::string scene_before = scene_change_bytes(scene(), {}, true);
  std::optional<Input> given;                          // the last state that was given, of the body as it ends
  std::optional<Input> later;                          // cells that wait at the end
  std::vector<std::pair<bool, std::uint64_t>> inputs;  // whether tools have done what they were asked, and how often
  for (const Input& input : recording.inputs) {
    const bool steps = input.kind == input_kind::step || input.kind == input_kind::restore ||
                       input.kind == input_kind::to_rest || input.kind == input_kind::to_rest_damped;
    inputs.emplace_back(steps, input.times);
    if (input.kind == input_kind::restore) given = input;
    const bool edits = input.kind == input_kind::cut || input.kind == input_kind::removed;
    if (edits) given.reset();
    if (edits || steps) later.reset();
    if (input.kind == input_kind::later) later = input;
  }
  std::vector<Snapshot::CutLater> left;
  if (later) {
    ByteReader in("cells to cut", later->bytes);
    left = take_snapshot(in).start.cut_later;
  }
  if (fingerprint(*parts_->topology, start.removed_cells, start.cuts) == recording.topology_hash) {
    parts_->set_body(start.removed_cells, start.cuts);
  }  // else Replay says so
  std::optional<Replay> made;
  const std::uint64_t version = scene().version();
  try {
    made.emplace(std::move(recording), parts_->solver(), scene());
  } catch (...) {
    if (scene().version() != version) {  // cleared
      parts_->set_body(before.removed_cells, before.cuts);
      ByteReader in("scene", scene_before);
      change_scene(scene(), in);
    }
    parts_->take_back(before, asked);
    throw;
  }
  Replay& replay = *made;
  parts_->recorder.reset();
  if (parts_->history) parts_->history->clear();
  parts_->see_tools();
  replay.on_body = [this](const std::vector<Index>& removed, const BodyCuts& cuts) { parts_->set_body(removed, cuts); };
  try {
    for (const auto& [steps, times] : inputs) {
      for (std::uint64_t k = 0; k < times; ++k) {
        replay.next();
        if (steps) parts_->see_tools();
      }
    }
  } catch (...) {
    parts_->waiting.clear();  // they were of what was before
    parts_->state_changed();
    throw;
  }
  Snapshot now = solver().snapshot();
  if (given && now.last_dt == 0.0) {
    ByteReader in("state", given->bytes);
    now.start = take_snapshot(in).start;
  }
  if (!left.empty()) now.start.cut_later = left;
  parts_->begin_again(now);
}

}  // namespace phymul
