// SPDX-License-Identifier: MIT
//
// What every backend shares: checks of options and states, snapshots, and the defaults of optional functions.
#include <phymul/backend.h>
#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/monitor.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/decimal.h"
#include "elastic/dissipation.h"
#include "elastic/local_steps.h"
#include "elastic/scaled_tables.h"
#include "half_step.h"
#include "interaction/joint_set.h"
#include "interaction/stiff_joints.h"
#include "profile.h"
#include "scene/tool_state.h"
#include "solver_input.h"
#include "topology/topology_match.h"

namespace phymul {
namespace {

constexpr std::size_t most_copies = 3;              // of request_read()
constexpr const char* passed_part = "time passed";  // of a Snapshot: s, without a step, since the last one

bool are_finite(const VecList& list) {
  return std::all_of(list.begin(), list.end(), [](const Vec3& v) { return v.allFinite(); });
}

bool is_in_plane(const State& state) {
  const auto flat = [](const Vec3& v) { return v.z() == 0.0; };
  return std::all_of(state.position.begin(), state.position.end(), flat) &&
         std::all_of(state.velocity.begin(), state.velocity.end(), flat);
}

constexpr const char* no_tools =
    "the scene has tools, which this backend does not take; use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_needles =
    "the scene has a needle, which this backend does not take; use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_surfaces =
    "the scene has a Blade or a tool with ToolContact::surface, which this backend does not take; use \"cpu\", "
    "\"gl-compute\" or \"reference\"";
constexpr const char* no_volumes =
    "the scene keeps volumes, which this backend does not do; use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_joints =
    "the scene has joints, which this backend does not take; use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_threads =
    "the scene has threads, which this backend does not take; use \"cpu\" or \"reference\"";
constexpr const char* no_dissipation =
    "the body has a material with Material::retardation_time or relaxation_strength, which this backend does not take; "
    "use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_scaled_stiffness =
    "the scene scales the stiffness of materials, which this backend cannot; use \"cpu\", \"gl-compute\" or "
    "\"reference\"";
constexpr const char* no_contacts =
    "the scene has contacts, which this backend does not take; use \"cpu\", \"gl-compute\" or \"reference\"";

}  // namespace

SolverBackend::SolverBackend(std::string name, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                             const SolverOptions& options)
    : name_(std::move(name)),
      topology_(std::move(topology)),
      scene_(&scene),
      options_(options),
      joints_(std::make_unique<JointSet>()),
      scaled_(std::make_unique<ScaledTables>()) {
  require_options(options_);
  require_same_body(*topology_, model());
  own_spectrum_ = options_.spectrum ? *options_.spectrum : estimate_spectrum(*topology_, topology_->rest);
  if (!std::isfinite(own_spectrum_.largest)) {
    throw Error(
        "the body's stiffness over its mass is beyond the range of numbers; expected masses in kg and stiffnesses in "
        "N/m (or a material in Pa) of a real body");
  }
  take_spectrum();
  if (options_.max_substeps > 1 && !topology_->domains.empty() && topology_->walls.empty()) {
    local_steps_ = choose_local_steps(*topology_, own_spectrum_, options_.max_substeps);
  }
  spacing_ = mean_spacing(model());
  // Cells alone make a body, without neighbours to take a spacing from.
  if (!(spacing_ > 0.0)) spacing_ = body_size(model()) / std::cbrt(static_cast<double>(topology_->particle_count));
  edits_seen_ = topology_->edits;
  domains_seen_ = topology_->edited.size();
  copies_seen_ = topology_->copied.size();
  exchanged_seen_ = topology_->exchanged.size();
  largest_before_edits_ = topology_->edits == 0 ? own_spectrum_.largest : NAN;  // not known of an edited body
  scene_->prepare(frame_);
  joints_->follow(*scene_);
  scene_version_ = scene_->version();
  values_version_ = scene_->values_version();
  if (options_.profile) profile_ = std::make_unique<Profile>();
}

SolverBackend::~SolverBackend() = default;

void SolverBackend::follow_scene() {
  if (scene_version_ != scene_->version()) {
    scene_->prepare(frame_);
    follow_joints();
    do_scene_changed();
  } else if (values_version_ != scene_->values_version()) {
    do_values_changed();
  }
  if (scene_version_ != scene_->version() || values_version_ != scene_->values_version()) {
    loose_.reset();
    all_held_.reset();
  }
  scene_version_ = scene_->version();
  values_version_ = scene_->values_version();
}

void SolverBackend::require_fitting(const State& state) const {
  const auto n = static_cast<std::size_t>(topology_->particle_count);
  if (state.position.size() != n || state.velocity.size() != n) {
    throw Error("Solver::reset: expected " + std::to_string(n) + " positions and velocities, got " +
                std::to_string(state.position.size()) + " and " + std::to_string(state.velocity.size()));
  }
  if (!is_finite(state)) {
    throw Error(
        "Solver::reset: the state has a time, position or velocity that is not finite; the solver keeps its own");
  }
  if (topology_->dimension == 2 && !is_in_plane(state)) {
    throw Error("Solver::reset: expected z = 0 in all positions and velocities of a two-dimensional model");
  }
  require_tool_states(state, topology_->particle_count, scene_->tools());
  require_joint_states(state, scene_->joints());
  require_thread_states(state, scene_->threads());
  for (const FluidState& fluid : state.fluids) {
    if (fluid.volume > 0.0 && std::isfinite(fluid.volume + fluid.pressure + fluid.pressure_before)) continue;
    throw Error("Solver::reset: expected a volume above 0 and finite pressures of fluid \"" + fluid.name + '"');
  }
}

void SolverBackend::require_supported() const {
  if (const char* const cause = do_cannot())
    throw Error(ErrorCode::not_supported, "backend \"" + name_ + "\": " + cause);
}

void SolverBackend::require_idle(const char* what) const {
  if (!is_stepping_.test()) return;
  throw Error(std::string(what) + ": a step of this solver has not returned yet; call it after the step");
}

void SolverBackend::reset(const State& given) {
  require_idle("Solver::reset");
  require_fitting(given);
  std::optional<State> kept;
  if (!topology_->removed.empty()) kept = without_removed(given);
  const State& state = kept ? *kept : given;
  require_supported();
  follow_scene();
  copies_.clear();
  do_reset(state);
  joints_->reset(state);
  bring_back_reports({});
  growth_ = growth_of_state_ = speed_ = 0.0;
  loose_.reset();
  all_held_.reset();
  last_ = {};
  first_beyond_ = -1;
}

void SolverBackend::begin_at_rest() {
  require_supported();
  follow_scene();
  joints_->reset({});
}

void SolverBackend::read(State& state) const {
  do_read(state);
  joints_->read(state);
}

const ToolReport& SolverBackend::tool_report(std::size_t row) const {
  const auto before = tools_before_.find(scene_->tools()[row].id);
  return before != tools_before_.end() ? before->second : do_tool_report(row);
}

const JointReport& SolverBackend::joint_report_at(std::size_t row) const {
  const auto before = joints_before_.find(scene_->joints()[row].id);
  return before != joints_before_.end() ? before->second : joints_->report(scene_->joints()[row]);
}

/// All of them or, where memory runs out, none.
void SolverBackend::bring_back_reports(const Snapshot& snapshot) {
  tools_before_.clear();
  joints_before_.clear();
  if (!snapshot.scene) return;
  std::map<std::uint64_t, ToolReport> tools;
  std::map<std::uint64_t, JointReport> joints;
  for (std::size_t row = 0; row < snapshot.tools.size(); ++row) {
    ToolReport& report = tools[scene_->tools()[row].id] = do_tool_report(row);
    report.last_pose = snapshot.tools[row].last_pose;
    report.force = snapshot.tools[row].force;
  }
  for (std::size_t row = 0; row < snapshot.joints.size(); ++row) {
    joints[scene_->joints()[row].id] = snapshot.joints[row];
  }
  tools_before_ = std::move(tools);
  joints_before_ = std::move(joints);
}

int SolverBackend::substeps() const {
  return local_steps_ ? std::max(1, static_cast<int>(local_steps_->substeps.size())) : 1;
}

void SolverBackend::solve_stiff_joints() {
  if (options_.max_substeps < 2 || topology_->domains.empty()) return;
  stiff_joints_ = std::make_unique<StiffJoints>();
  joints_->leave_out([this](const Scene& scene) { return solved_joints(scene, local_steps()); });
  follow_joints();
}

void SolverBackend::follow_joints() {
  joints_->follow(*scene_);
  if (stiff_joints_) stiff_joints_->follow(*scene_, *topology_, frame_.fixed, local_steps());
}

const TopologyTextures& SolverBackend::elastic() const {
  return scaled_->of(*topology_, scene_->stiffness_factors());
}

Snapshot SolverBackend::snapshot_without_hash() const {
  Snapshot snapshot;
  do_snapshot(snapshot);
  joints_->read(snapshot.state);
  if (last_.passed > 0.0) put_numbers(passed_part, {&last_.passed, 1}, snapshot);
  snapshot.growth = growth_;
  snapshot.max_speed = speed_;
  snapshot.removed_cells = topology_->removed;
  snapshot.cuts = topology_->cuts;
  snapshot.backend = name_;
  if (!scene_->tools().empty() && !takes_tools()) return snapshot;
  snapshot.scene = std::make_shared<const SceneParts>(scene_->parts());
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) {
    const ToolReport& report = tool_report(row);
    snapshot.tools.push_back({scene_->tools()[row].pose, report.last_pose, report.force});
  }
  for (std::size_t row = 0; row < scene_->joints().size(); ++row) snapshot.joints.push_back(joint_report_at(row));
  return snapshot;
}

void SolverBackend::restore(const Snapshot& snapshot) {
  if (has_part(passed_part, snapshot)) {
    const double passed = numbers_of(passed_part, 1, snapshot).front();
    Snapshot of_backend = snapshot;
    std::erase_if(of_backend.parts, [](const Snapshot::Part& part) { return part.name == passed_part; });
    restore(of_backend);
    last_.passed = std::max(passed, 0.0);
    return;
  }
  require_idle("Solver::restore");
  if (snapshot.topology_hash != 0 && snapshot.topology_hash != topology_hash()) {
    throw Error(
        "Solver::restore: expected a snapshot of this solver's body, got one of another shape, material, order of "
        "particles, other options of the tables, other cuts or other removed cells; the solver keeps its state. "
        "Restore it into a solver over the same tables, or reset() to the snapshot's state where only positions are "
        "wanted");
  }
  require_fitting(snapshot.state);
  require_supported();
  if (!snapshot.displacement.empty() && snapshot.displacement.size() != snapshot.state.position.size()) {
    throw Error("Solver::restore: expected as many displacements as positions (" +
                std::to_string(snapshot.state.position.size()) + "), or none; got " +
                std::to_string(snapshot.displacement.size()));
  }
  if (!are_finite(snapshot.displacement)) {
    throw Error("Solver::restore: the snapshot has a displacement that is not finite; the solver keeps its state");
  }
  const SceneParts own = scene_->parts();
  if (const std::string found = snapshot.scene ? difference(*snapshot.scene, own) : ""; !found.empty()) {
    throw Error(
        "Solver::restore: expected a scene with the snapshot's tools, joints and threads, in its order; the first that "
        "differs, or that only one of them has, is " +
        found +
        ". Call Scene::bring_back(*snapshot.scene) before, or clear Snapshot::scene to keep those of the scene");
  }
  if (snapshot.scene && (snapshot.tools.size() != own.tools.size() || snapshot.joints.size() != own.joints.size())) {
    throw Error("Solver::restore: expected a report for each of the snapshot's tools and joints");
  }
  if (!(snapshot.last_dt >= 0.0) || !std::isfinite(snapshot.last_dt) || snapshot.steps_at_rest < 0) {
    throw Error("Solver::restore: expected a finite last step of 0 s or more and no negative count of steps at rest");
  }
  follow_scene();
  do_restore(snapshot);
  joints_->reset(snapshot.state);
  bring_back_reports(snapshot);
  copies_.clear();
  growth_ = snapshot.growth, speed_ = snapshot.max_speed;
  loose_.reset();
  all_held_.reset();
  first_beyond_ = -1;
  last_ = {.dt = snapshot.last_dt, .report = {.max_speed = speed_, .growth = growth_}};
  last_.report.at_rest = snapshot.steps_at_rest >= options_.rest_steps;
  growth_of_state_ = 0.0;
}

void SolverBackend::start(const State& state, double dt) {
  if (!(dt > 0.0) || !std::isfinite(dt))
    throw Error("Solver::start: expected a finite dt above 0 s; got " + to_decimal(dt));
  require_fitting(state);  // before anything is computed from it
  State earlier = state;
  to_half_step_before(elastic(), *scene_, {dt, options_.damping.factor_at(dt)}, earlier, substep_forces(state, dt));
  reset(earlier);
}

ParticleBuffer SolverBackend::attractor_buffer() const {
  return topology_->base_count > 0 ? do_attractor_buffer() : ParticleBuffer{};
}

const ToolReport& SolverBackend::do_tool_report(std::size_t) const {
  throw Error(ErrorCode::not_supported, no_tools);
}

void SolverBackend::do_request_read() {
  if (copies_.size() == most_copies) copies_.pop_back();
  copies_.push_back(read());
}

bool SolverBackend::do_collect(State& state) {
  if (copies_.empty()) return false;
  state = std::move(copies_.front());
  copies_.erase(copies_.begin());
  return true;
}

void SolverBackend::do_snapshot(Snapshot& snapshot) const {
  do_read(snapshot.state);
}

void SolverBackend::refuse_parts(const Snapshot& snapshot) const {
  if (snapshot.parts.empty()) return;
  throw Error(ErrorCode::not_supported, "Solver::restore: the snapshot holds \"" + snapshot.parts.front().name +
                                            "\", of which this solver of \"" + name_ +
                                            "\" knows nothing; restore it with the same backend and options");
}

void SolverBackend::do_restore(const Snapshot& snapshot) {
  refuse_parts(snapshot);
  do_reset(snapshot.state);
}

const char* SolverBackend::beyond_devices() const {
  if (std::ranges::any_of(scene_->volume_constraints(), [](const VolumeConstraint& kept) {
        return kept.fluid.law != FluidLaw::incompressible || kept.fluid.conductance > 0.0;
      })) {
    return "the scene has a fluid that is not incompressible or has an opening, which this backend does not do; use "
           "\"cpu\" or \"reference\"";
  }
  if (local_steps_) {
    return "SolverOptions::max_substeps is above 1, and parts of this body would have local steps, which this backend "
           "does not do; use \"cpu\" or \"reference\"";
  }
  return nullptr;
}

const char* SolverBackend::do_cannot() const {
  if (!scene_->tools().empty() && !takes_tools()) return no_tools;
  if (has_needle(scene_->tools())) return no_needles;
  if (touches_surface(scene_->tools())) return no_surfaces;
  if (const char* const cause = beyond_devices()) return cause;
  if (!scene_->threads().empty()) return no_threads;
  if (!scene_->joints().empty()) return no_joints;
  if (!topology_->dissipation.empty()) return no_dissipation;
  if (!scene_->stiffness_factors().empty()) return no_scaled_stiffness;
  if (!scene_->volume_constraints().empty() && !do_takes_volumes()) return no_volumes;
  return scene_->contacts() ? no_contacts : nullptr;
}

Momentum SolverBackend::do_momentum(const Vec3& about) const {
  const State state = read();
  return {linear_momentum(model(), state), angular_momentum(model(), state, about)};
}

ParticleBuffer SolverBackend::do_position_buffer() const {
  State state = read();
  shown_ = std::move(state.position);
  return {.position = shown_};
}

ParticleBuffer SolverBackend::do_attractor_buffer() const {
  const State state = read();
  attracted_.resize(state.position.size());
  attractors(*topology_, state.position, attracted_);
  return {.position = attracted_};
}

}  // namespace phymul
