// SPDX-License-Identifier: MIT
//
// A call of step() or run_to_rest(): step limit, thresholds, failures and the rest test, once for all backends.
#include <phymul/backend.h>
#include <phymul/elasticity.h>
#include <phymul/monitor.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "elastic/dissipation.h"
#include "elastic/domain_forces.h"
#include "elastic/local_steps.h"
#include "elastic/material_spectra.h"
#include "interaction/joint_set.h"
#include "model/cell_geometry.h"
#include "scene/loose_parts.h"
#include "solver_input.h"

namespace phymul {
namespace {

/// A step this much beyond the limit still counts as at it: the limit itself was rounded.
constexpr double limit_slack = 1e-9;
/// Of the step before: what rounding leaves at the end of calls whose times add up to one. No state of a body moves in
/// it, but what touches it would put right, with a blow, what single precision has rounded in places.
constexpr double remainder_share = 1e-6;
/// Speeds beyond this many times spacing times omega_max (twice the wave speed or so) are a failure, not a motion.
constexpr double runaway_factor = 1e6;
/// Of the body, from rest: with parts held, stretches of ten and more lie between.
constexpr double farthest_sizes = 10.0;

/// Shares of the stable step where nothing is known of the deformation, and where it has not raised the frequency. The
/// second leaves the 20 % (0.9^-2 = 1.23) by which frequency_growth() may be too low.
constexpr double usual_share = 0.5, longest_share = 0.9;
/// A growth above (0.9 / 0.25)^2 = 13, besides a stiffening law's, is that of single domains, which do not set the step
/// alone.
constexpr double shortest_share = 0.25;
/// For longer than so many steps nothing says how a body will deform.
constexpr double foreseen_steps = 16.0;

/// m, that points of a tool within a spacing of its position move from one pose to another.
double travel(const ToolPose& from, const ToolPose& to, double spacing) {
  return (to.position - from.position).norm() +
         spacing * to.orientation.normalized().angularDistance(from.orientation.normalized());
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

/// s. The stiff part's dt^2 lambda, which does not fall with dt, leaves 2 (1 + d) - most_of_substeps to all else.
double longest_with_substeps(const StepBound& all_else, const Damping& damping) {
  const auto longest = [&](double d) {
    const double left = d - 0.5 * most_of_substeps;  // 2 (1 + left) is what is left
    return left > -1.0 ? largest_step(all_else, left) : 0.0;
  };
  double fits = 0.0, most = longest(damping.factor);
  if (damping.rate == 0.0) return most;
  for (int turn = 0; turn < 50; ++turn) {
    const double middle = 0.5 * (fits + most);
    (middle <= longest(damping.factor_at(middle)) ? fits : most) = middle;
  }
  return fits;
}

class AtReturn {
 public:
  explicit AtReturn(std::atomic_flag& flag) : flag_(flag) {}
  AtReturn(const AtReturn&) = delete;
  AtReturn& operator=(const AtReturn&) = delete;
  ~AtReturn() { flag_.clear(); }

 private:
  std::atomic_flag& flag_;
};

}  // namespace

double Damping::factor_at(double dt) const {
  return factor * std::exp(-rate * dt);
}

/// Eigenvalues of sums are at most the sums of the largest (Weyl).
double SolverBackend::step_limit(const Damping& damping) const {
  const JointBounds& joints = joints_->bounds(*scene_, topology_->mass);
  const auto longest = [&](double factor) {
    const StepBound bound{factor * stiffness_ + joints.left_stiffness, factor * viscosity_ + joints.left_damping};
    double step = largest_step(bound, damping.factor);
    if (damping.rate == 0.0 || !std::isfinite(step)) return step;
    // A longer step is damped more, and what is damped more takes only a shorter one. Each turn comes nearer to the
    // step where both agree, by seven times at least.
    for (int turn = 0; turn < 20; ++turn) step = largest_step(bound, damping.factor_at(step));
    return step;
  };
  if (!local_steps_) return longest(stiffness_factor());
  // Local steps hide a share of the stiffness, and as much of what dissipates in proportion to it.
  const double rate = local_steps_->rate(scene_->stiffness_factors());
  if (substeps() == 1) return longest(rate / own_spectrum_.largest);
  const StepBound bound{(1.0 - most_of_substeps / 4.0) * rate + joints.left_stiffness, joints.left_damping};
  return std::max(longest(stiffness_factor()), longest_with_substeps(bound, damping));
}

double SolverBackend::suggested_step(double seconds) const {
  const double stable = stable_step();
  if (substeps() > 1) return usual_share * stable;
  double growth = growth_, speed = speed_;
  if (growth == 0.0) {
    const State state = read();
    if (growth_of_state_ == 0.0) growth_of_state_ = frequency_growth(elastic(), state.position);
    growth = growth_of_state_;
    speed = 0.0;
    for (const Vec3& v : state.velocity) speed = std::max(speed, v.norm());
  }
  if (!std::isfinite(growth)) return usual_share * stable;
  const bool is_foreseen = seconds <= foreseen_steps * longest_share * stable;
  double way = 0.0;  // m
  if (is_foreseen) {
    way = speed * seconds;
    for (std::size_t row = 0; row < scene_->tools().size(); ++row) {
      way = std::max(way, travel(do_tool_report(row).pose, scene_->tools()[row].pose, spacing_));
    }
  }
  const double stretch = 1.0 + way / spacing_;
  const double share = longest_share / std::sqrt(growth * stretch * stretch);
  const double shortest = shortest_share / std::sqrt(most_stiffening(elastic()));
  return stable * std::clamp(share, shortest, is_foreseen ? longest_share : usual_share);
}

StepReport SolverBackend::step(int n, double dt) {
  return advance(n, dt, false, options_.damping);
}

RestResult SolverBackend::run_to_rest(int max_steps, double dt, const Damping& damping) {
  RestResult result;
  result.report = advance(max_steps, dt, true, damping);
  const StepReport& report = result.report;
  result.status = !report.ok()     ? RestStatus::failed
                  : report.at_rest ? RestStatus::converged
                  : report.stopped ? RestStatus::stopped
                                   : RestStatus::step_limit;
  if (result.converged() || result.status == RestStatus::step_limit) {
    const State state = read();
    result.collapsed = first_collapsed(*topology_, state.position);
    result.folded = first_folded_cell(model(), state.position);
    if (!loose_) loose_ = first_loose(*scene_, state.joints);
    if (!result.converged()) result.loose = *loose_;
  }
  if (result.folded >= 0) result.folded_at = cell_centre(model().cells[result.folded], model().rest);
  return result;
}

bool SolverBackend::any_tool_grasps() const {
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) {
    if (do_tool_report(row).force.held_mass > 0.0) return true;
  }
  return false;
}

SolverBackend::StepPlan SolverBackend::plan_for(int n, double dt, const Damping& damping, bool beyond_limit) const {
  StepPlan plan{.steps = n, .dt = dt, .damping_factor = damping.factor_at(dt)};
  const double joints = joints_->bounds(*scene_, topology_->mass).stiffness;
  const Spectrum body = spectrum();
  // Of the body alone, where it has any stiffness: a stiff joint must not loosen the rest test.
  const double omega = std::sqrt(body.largest > 0.0 ? body.largest : joints);
  plan.omega_max = std::sqrt(body.largest + joints);
  // A bound that is too large would loosen it too: of the model's own stiffness, or less.
  const double at_rest = omega * std::sqrt(std::min(1.0, 1.0 / stiffness_factor()));
  plan.speed_at_rest = options_.rest_tolerance * spacing_ * at_rest;
  plan.acceleration_at_rest = plan.speed_at_rest * at_rest;
  const bool clamps = spacing_ > 0.0 && !beyond_limit && !grows_by_itself(body);
  plan.largest_acceleration =
      clamps ? options_.max_displacement_per_step * spacing_ / (dt * dt) : std::numeric_limits<double>::infinity();
  plan.runaway_speed = omega * spacing_ > 0.0 ? runaway_factor * spacing_ * omega : std::numeric_limits<double>::max();
  plan.rest_steps = options_.rest_steps;
  return plan;
}

void SolverBackend::report_failure(const Motion& motion, StepReport& report) const {
  if (motion.lost) {
    report.status = StepStatus::device_lost;
  } else if (motion.lost_volume >= 0) {
    report.status = StepStatus::volume_lost;
    const auto row = static_cast<std::size_t>(motion.lost_volume);
    report.particle = scene_->volume_constraints()[row].triangles.front()[0];
    report.cause =
        "no small displacement of its free particles restores it: all of them are held, or the surface is flat or "
        "strongly deformed";
  } else if (*motion.not_finite != '\0') {
    report.status = StepStatus::not_finite;
    report.cause = motion.not_finite;
  } else if (motion.bad_particle >= 0) {
    report.status = StepStatus::not_finite;
    report.particle = motion.bad_particle;
    report.cause = likely_cause(*topology_, spectrum(), report.dt, report.stable_step, any_tool_grasps());
  }
}

StepReport SolverBackend::advance(int n, double dt, bool stop_at_rest, const Damping& damping) {
  StepReport report;
  report.dt = dt;
  if (is_stepping_.test_and_set()) {
    report.status = StepStatus::invalid_step;
    report.cause =
        "another call of step() or run_to_rest() of this solver has not returned yet: one thread steps it, and nothing "
        "that it calls meanwhile (SolverOptions::progress) may";
    return report;
  }
  const AtReturn done(is_stepping_);
  report.time = do_time();
  report.stable_step = step_limit(damping);
  if (const char* const cause = why_no_steps(n, dt, stop_at_rest, damping)) {
    report.status = StepStatus::invalid_step;
    report.cause = cause;
    return report;
  }
  report.beyond_limit = dt > report.stable_step * (1.0 + limit_slack);
  if (report.beyond_limit && options_.on_unstable == UnstableStep::refuse) {
    report.status = StepStatus::unstable_step;
    return report;
  }
  if (const char* const cause = do_cannot()) {
    report.status = StepStatus::not_supported;
    report.cause = cause;
    return report;
  }
  if (scene_version_ != scene_->version() || values_version_ != scene_->values_version()) last_.report.at_rest = false;
  follow_scene();
  if (n > 0 && !stop_at_rest && last_.passed + n * dt < remainder_share * last_.dt && do_pass_time(n * dt)) {
    last_.passed += n * dt;
    return still(report);
  }
  StepPlan plan = plan_for(n, dt, damping, report.beyond_limit);
  plan.stop_at_rest = stop_at_rest;
  const int broken_before = joints_->broken(), gave_way_before = tissue_gave_way();
  Motion motion = run(plan, report);
  if (motion.steps == 0) motion.strain = {.growth = 0.0};
  report.steps = motion.steps;
  report.time = do_time();
  report.residual = motion.max_force;
  report.max_speed = motion.max_speed;
  report.growth = motion.strain.growth;
  if (motion.steps > 0) {
    growth_ = motion.strain.growth;
    speed_ = motion.max_speed;
    growth_of_state_ = 0.0;
    bring_back_reports({});
  }
  report.force_clamped = motion.force_clamped;
  report.springs_broken = joints_->broken() - broken_before;
  if (report.springs_broken > 0) {
    loose_.reset();
    all_held_.reset();
  }
  report.tissue_gave_way = tissue_gave_way() - gave_way_before;
  report.at_rest = motion.steps_at_rest >= options_.rest_steps;
  note_strain(motion, report);
  report_failure(motion, report);
  const bool stands = report.ok() || report.status == StepStatus::carried_away;  // else an older state does
  if (motion.steps > 0) last_ = {.dt = dt, .report = stands ? report : last_.report};
  return report;
}

/// Of a call that passes time alone: what the last step has found still holds.
StepReport SolverBackend::still(const StepReport& call) const {
  StepReport report = last_.report;
  report.steps = report.springs_broken = report.tissue_gave_way = 0;
  report.force_clamped = report.stopped = false;
  report.time = do_time();
  report.dt = call.dt;
  report.stable_step = call.stable_step;
  report.beyond_limit = call.beyond_limit;
  return report;
}

int SolverBackend::tissue_gave_way() const {
  int all = 0;
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) all += do_tool_report(row).tissue_gave_way;
  return all;
}

void SolverBackend::note_strain(const Motion& motion, StepReport& report) {
  if (motion.strain.growth != 0.0) {
    if (motion.strain.beyond_law == 0) first_beyond_ = -1;
    if (motion.strain.beyond_law > 0 && first_beyond_ < 0) {
      first_beyond_ = motion.strain.first_beyond;
      beyond_since_ = report.time;
    }
  }
  report.beyond_law = motion.strain.beyond_law;
  report.inverted = motion.strain.inverted;
  report.first_beyond = report.beyond_law > 0 ? first_beyond_ : -1;
  report.beyond_since = report.first_beyond < 0 ? 0.0 : beyond_since_;
  if (motion.strain.beyond_law == 0 || motion.max_displacement <= farthest_sizes * body_size(model())) return;
  if (!all_held_) {
    State of_joints;
    joints_->read(of_joints);
    all_held_ = loose_parts(*scene_, held_particles(*scene_, of_joints.joints), of_joints.joints).empty();
  }
  if (!*all_held_) return;
  double imposed = 0.0;
  for (std::size_t i = 0; i < frame_.target.size(); ++i) {
    Vec3 moved = frame_.target[i] - topology_->rest[i];
    for (int axis = 0; axis < 3; ++axis) {
      if ((frame_.fixed[i] >> axis & 1) == 0) moved[axis] = 0.0;
    }
    imposed = std::max(imposed, moved.norm());
  }
  const State now = read();
  for (Index i = 0; i < topology_->particle_count; ++i) {
    if ((now.position[i] - topology_->rest[i]).norm() <= imposed + farthest_sizes * body_size(model())) continue;
    report.status = StepStatus::carried_away;
    report.particle = i;
    return;
  }
}

double SolverBackend::stiffness_factor() const {
  const std::vector<double>& factors = scene_->stiffness_factors();
  if (factors.empty() || topology_->domains.empty() || own_spectrum_.largest == 0.0) return 1.0;
  if (factors.size() == 1) return factors.front();
  // With the first factors, even if they are alike: others may come in steps, which do not allocate.
  if (!materials_) materials_ = std::make_unique<MaterialSpectra>(*topology_);
  const auto [least, most] = std::ranges::minmax(factors);
  return least == most ? most : materials_->largest(own_spectrum_.largest, factors) / own_spectrum_.largest;
}

Spectrum SolverBackend::spectrum() const {
  Spectrum now = own_spectrum_;
  now.largest *= stiffness_factor();
  now.most_negative *= stiffness_factor();
  now.largest_imaginary *= stiffness_factor();
  return now;
}

}  // namespace phymul
