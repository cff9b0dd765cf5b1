// SPDX-License-Identifier: MIT
//
// The non-virtual half of Solver: argument checks, step limit, failure policy and rest test, once for all backends.
#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/monitor.h>
#include <phymul/solver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/decimal.h"
#include "profile.h"
#include "scene/tool_state.h"
#include "solver_input.h"
#include "topology/topology_match.h"

namespace phymul {
namespace {

/// A step this much beyond the limit still counts as at it: the limit itself was rounded.
constexpr double limit_slack = 1e-9;
/// Speeds beyond this many times spacing times omega_max (twice the wave speed or so) are a failure, not a motion.
constexpr double runaway_factor = 1e6;
/// Of request_read.
constexpr std::size_t most_copies = 3;

bool are_finite(const VecList& list) {
  return std::all_of(list.begin(), list.end(), [](const Vec3& v) { return v.allFinite(); });
}

bool is_in_plane(const State& state) {
  const auto flat = [](const Vec3& v) { return v.z() == 0.0; };
  return std::all_of(state.position.begin(), state.position.end(), flat) &&
         std::all_of(state.velocity.begin(), state.velocity.end(), flat);
}

/// A model whose motion grows by itself shows that; a cut would hide it.
bool grows_by_itself(const Spectrum& spectrum) {
  return spectrum.most_negative < 0.0 || spectrum.largest_imaginary > 0.0;
}

const char* likely_cause(const TopologyTextures& topology, const Spectrum& spectrum, double dt, double limit,
                         bool grasps) {
  if (dt > limit) return "the step is beyond the stable step at rest; make dt smaller";
  if (spectrum.most_negative < 0.0 && topology.options.reaction == Reaction::full && topology.base_count > 0) {
    return "the full reaction gives back more force than it takes and grows without bound at any step; use "
           "Reaction::conservative";
  }
  if (spectrum.most_negative < 0.0) return "this model is unstable at rest at any step; use Reaction::conservative";
  if (grasps) {
    return "a tool holds particles and was moved too fast for them. Where its poses come from its forces, what it "
           "holds belongs to that loop, which grows by itself unless it is told of it: VirtualCoupling::follow with "
           "the whole ToolForce; a smaller dt or more damping does not help. Else the deformation raised the body's "
           "stiffness, or a load is extreme: halve dt or raise damping";
  }
  return "the deformation raised the body's stiffness until dt passed its stable step, or a load is extreme; halve dt "
         "or raise damping";
}

constexpr const char* no_tools =
    "the scene has tools, which this backend does not take; use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_needles =
    "the scene has a needle, which this backend does not take; use \"gl-compute\", \"cpu\" or \"reference\"";
constexpr const char* no_volumes =
    "the scene keeps volumes, which this backend does not do; use \"cpu\", \"gl-compute\" or \"reference\"";
constexpr const char* no_contacts =
    "the scene has contacts, which this backend does not take; use \"cpu\", \"gl-compute\" or \"reference\"";

}  // namespace

double Damping::factor_at(double dt) const {
  return factor * std::exp(-rate * dt);
}

Solver::Solver(std::string name, std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
               const SolverOptions& options)
    : name_(std::move(name)), topology_(std::move(topology)), scene_(&scene), options_(options) {
  require_options(options_);
  require_same_body(*topology_, model());
  spectrum_ = options_.spectrum ? *options_.spectrum : estimate_spectrum(*topology_, topology_->rest);
  if (!std::isfinite(spectrum_.largest)) {
    throw Error(
        "the body's stiffness over its mass is beyond the range of numbers; expected masses in kg and stiffnesses in "
        "N/m (or a material in Pa) of a real body");
  }
  stable_step_ = phymul::stable_step(spectrum_, options_.damping.factor);
  spacing_ = mean_spacing(model());
  // Cells alone make a body, without neighbours to take a spacing from.
  if (!(spacing_ > 0.0)) spacing_ = body_size(model()) / std::cbrt(static_cast<double>(topology_->particle_count));
  scene_->prepare(frame_);
  scene_version_ = scene_->version();
  values_version_ = scene_->values_version();
  if (options_.profile) profile_ = std::make_unique<Profile>();
}

Solver::~Solver() = default;

void Solver::follow_scene() {
  if (scene_version_ != scene_->version()) {
    scene_->prepare(frame_);
    do_scene_changed();
  } else if (values_version_ != scene_->values_version()) {
    do_values_changed();
  }
  scene_version_ = scene_->version();
  values_version_ = scene_->values_version();
}

void Solver::require_fitting(const State& state) const {
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
}

void Solver::require_supported() const {
  if (const char* const cause = do_cannot()) throw Error("backend \"" + name_ + "\": " + cause);
}

void Solver::reset(const State& state) {
  require_fitting(state);
  require_supported();
  follow_scene();
  copies_.clear();
  do_reset(state);
}

void Solver::reset() {
  reset(rest_state(model()));
}

std::uint64_t Solver::body() const {
  if (!body_) body_ = fingerprint(*topology_);
  return *body_;
}

Snapshot Solver::snapshot() const {
  Snapshot snapshot;
  do_snapshot(snapshot);
  snapshot.body = body();
  return snapshot;
}

void Solver::restore(const Snapshot& snapshot) {
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
  if (snapshot.body != 0 && snapshot.body != body()) {
    throw Error(
        "Solver::restore: expected a snapshot of this solver's body, got one of another shape, material, order of "
        "particles or other options of the tables; the solver keeps its state. Restore it into a solver over the same "
        "tables, or reset() to the snapshot's state where only positions are wanted");
  }
  if (!(snapshot.last_dt >= 0.0) || !std::isfinite(snapshot.last_dt) || snapshot.steps_at_rest < 0) {
    throw Error("Solver::restore: expected a finite last step of 0 s or more and no negative count of steps at rest");
  }
  follow_scene();
  do_restore(snapshot);
  copies_.clear();
}

void Solver::start(const State& state, double dt) {
  if (!(dt > 0.0) || !std::isfinite(dt))
    throw Error("Solver::start: expected a finite dt above 0 s; got " + to_decimal(dt));
  reset(state);  // which refuses what does not fit before anything is computed from it
  LoadFrame at_start;
  scene_->prepare(at_start);
  scene_->evaluate(state.time, at_start);
  VecList force(state.position.size());
  elastic_forces(*topology_, state.position, force);
  // The scheme steps from v- to v+ = d v- + a dt; the velocity in the middle is to be the given one.
  const double d = options_.damping.factor_at(dt);
  State earlier = state;
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (!at_start.force.empty()) force[i] += at_start.force[i];
    const Vec3 acceleration = at_start.gravity + force[i] / topology_->mass[i];
    for (int axis = 0; axis < topology_->dimension; ++axis) {
      const bool imposed = !at_start.fixed.empty() && (at_start.fixed[i] >> axis & 1);
      if (!imposed) earlier.velocity[i][axis] = (2.0 * state.velocity[i][axis] - dt * acceleration[axis]) / (1.0 + d);
    }
  }
  reset(earlier);
}

StepReport Solver::step(int n, double dt) {
  return advance(n, dt, false);
}
StepReport Solver::run_to_rest(int max_steps, double dt) {
  return advance(max_steps, dt, true);
}

bool Solver::any_tool_grasps() const {
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) {
    if (do_tool_report(row).force.held_mass > 0.0) return true;
  }
  return false;
}

StepReport Solver::advance(int n, double dt, bool stop_at_rest) {
  StepReport report;
  report.time = do_time();
  report.dt = dt;
  report.stable_step = stable_step_;
  report.to_rest = stop_at_rest;
  if (const char* const cause = why_no_steps(n, dt, stop_at_rest, options_.damping)) {
    report.status = StepStatus::invalid_step;
    report.cause = cause;
    return report;
  }
  report.beyond_limit = dt > stable_step_ * (1.0 + limit_slack);
  if (report.beyond_limit && options_.on_unstable == UnstableStep::refuse) {
    report.status = StepStatus::unstable_step;
    return report;
  }
  if (do_cannot() != nullptr) {
    report.status = StepStatus::not_supported;
    report.cause = do_cannot();
    return report;
  }
  follow_scene();

  StepPlan plan;
  plan.steps = n;
  plan.dt = dt;
  plan.damping_factor = options_.damping.factor_at(dt);
  const double omega = std::sqrt(spectrum_.largest);
  plan.speed_at_rest = options_.rest_tolerance * spacing_ * omega;
  plan.acceleration_at_rest = plan.speed_at_rest * omega;
  const bool cuts = spacing_ > 0.0 && !report.beyond_limit && !grows_by_itself(spectrum_);
  plan.largest_acceleration =
      cuts ? options_.largest_push * spacing_ / (dt * dt) : std::numeric_limits<double>::infinity();
  plan.runaway_speed = omega * spacing_ > 0.0 ? runaway_factor * spacing_ * omega : std::numeric_limits<double>::max();
  plan.stop_at_rest = stop_at_rest;
  plan.rest_steps = options_.rest_steps;

  const Motion motion = run(plan, report);
  report.steps = motion.steps;
  report.time = do_time();
  report.residual = motion.max_force;
  report.max_speed = motion.max_speed;
  report.cut = motion.cut;
  report.at_rest = motion.steps_at_rest >= options_.rest_steps;
  if (stop_at_rest && report.at_rest && !motion.lost) {
    const State state = read();
    report.collapsed = first_collapsed(*topology_, state.position);
    report.folded = first_folded_cell(model(), state.position);
  }
  if (motion.lost) {
    report.status = StepStatus::device_lost;
  } else if (motion.lost_volume >= 0) {
    report.status = StepStatus::volume_lost;
    const auto row = static_cast<std::size_t>(motion.lost_volume);  // of none, where it went before a late report
    if (row < scene_->volumes().size()) report.particle = scene_->volumes()[row].triangles.front()[0];
    report.cause =
        "no small move of its free particles brings it back: all of them are held, or the surface is flat or torn far "
        "out of shape";
  } else if (motion.full_needle >= 0) {
    report.status = StepStatus::needle_full;
    report.cause =
        "Give the needle a larger Needle::spread or use the backend \"cpu\"; to go on, take the needle out with "
        "ToolHandle::place(), or reset()";
  } else if (motion.bad_particle >= 0) {
    report.status = StepStatus::not_finite;
    report.particle = motion.bad_particle;
    report.cause = likely_cause(*topology_, spectrum_, dt, stable_step_, any_tool_grasps());
  }
  return report;
}

void Solver::read(State& state) const {
  do_read(state);
}

State Solver::read() const {
  State state;
  do_read(state);
  return state;
}

Energy Solver::energy() const {
  return do_energy();
}

Momentum Solver::momentum(const Vec3& about) const {
  return do_momentum(about);
}

void Solver::request_read() {
  do_request_read();
}

bool Solver::collect(State& state) {
  return do_collect(state);
}

ParticleBuffer Solver::position_buffer() const {
  return do_position_buffer();
}

ParticleBuffer Solver::attractor_buffer() const {
  return topology_->base_count > 0 ? do_attractor_buffer() : ParticleBuffer{};
}

const ToolReport& Solver::do_tool_report(std::size_t) const {
  throw Error(no_tools);
}

std::string Solver::device() const {
  return do_device();
}

void Solver::do_request_read() {
  if (copies_.size() == most_copies) copies_.pop_back();
  copies_.push_back(read());
}

bool Solver::do_collect(State& state) {
  if (copies_.empty()) return false;
  state = std::move(copies_.front());
  copies_.erase(copies_.begin());
  return true;
}

void Solver::do_snapshot(Snapshot& snapshot) const {
  do_read(snapshot.state);
}

void Solver::refuse_parts(const Snapshot& snapshot) const {
  if (snapshot.parts.empty()) return;
  throw Error("Solver::restore: the snapshot holds \"" + snapshot.parts.front().name + "\", of which the backend \"" +
              name_ + "\" knows nothing; restore it in the backend that made it");
}

void Solver::do_restore(const Snapshot& snapshot) {
  refuse_parts(snapshot);
  do_reset(snapshot.state);
}

const char* Solver::do_cannot() const {
  if (!scene_->tools().empty() && !takes_tools()) return no_tools;
  if (has_needle(scene_->tools())) return no_needles;
  if (!scene_->volumes().empty() && !do_takes_volumes()) return no_volumes;
  return scene_->contacts() ? no_contacts : nullptr;
}

Momentum Solver::do_momentum(const Vec3& about) const {
  const State state = read();
  return {linear_momentum(model(), state), angular_momentum(model(), state, about)};
}

ParticleBuffer Solver::do_position_buffer() const {
  State state = read();
  shown_ = std::move(state.position);
  return {.position = shown_};
}

ParticleBuffer Solver::do_attractor_buffer() const {
  const State state = read();
  attracted_.resize(state.position.size());
  attractors(*topology_, state.position, attracted_);
  return {.position = attracted_};
}

}  // namespace phymul
