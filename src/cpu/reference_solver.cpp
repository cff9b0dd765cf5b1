// SPDX-License-Identifier: MIT
#include "cpu_backends.h"

#include <phymul/backend.h>
#include <phymul/elasticity.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "elastic/dissipation.h"
#include "elastic/local_steps.h"
#include "integrate.h"
#include "interaction/joint_set.h"
#include "interaction/stiff_joints.h"
#include "interaction/tool_set.h"
#include "interaction/touching.h"
#include "solver/profile.h"
#include "solver/step_order.h"

namespace phymul::cpu {
namespace {

class ReferenceSolver final : public SolverBackend {
 public:
  ReferenceSolver(std::shared_ptr<const TopologyTextures> shared, const Scene& scene_in,
                  const SolverOptions& options_in)
      : SolverBackend("reference", std::move(shared), scene_in, options_in),
        force_(topology().particle_count),
        next_position_(topology().particle_count),
        next_velocity_(topology().particle_count),
        dissipation_(topology()) {
    if (local_steps() != nullptr) {
      local_.emplace(*local_steps());
      for (VecList* list : {&local_x_, &local_a_, &local_f_}) list->resize(local_steps()->particle.size());
    }
    solve_stiff_joints();
    if (Profile* profile = profiling()) {
      forces_row_ = profile->row("forces");
      move_row_ = profile->row("move");
      checks_row_ = profile->row("checks");
    }
    reset();
  }

 private:
  friend StepOrder;
  void do_reset(const State& state) override {
    state_.time = state.time;
    state_.position = state.position;
    state_.velocity = state.velocity;
    follow_tools();
    tools_.reset(scene(), state);
    touching_.reset(scene(), state);
    last_dt_ = 0.0;
    steps_at_rest_ = 0;
    dissipation_.reset({});
    if (local_) local_->reset();
    scene().evaluate(state_.time, frame());
  }

  void do_snapshot(Snapshot& snapshot) const override {
    do_read(snapshot.state);
    snapshot.last_dt = last_dt_;
    snapshot.steps_at_rest = steps_at_rest_;
    put_strains(dissipation_.memory(), snapshot);
    if (local_) local_->put(snapshot);
  }

  void do_restore(const Snapshot& snapshot) override {
    const bool strained = !dissipation_.empty() && has_strains(snapshot);
    const bool pushed = local_ && LocalForces::has(snapshot);
    if (snapshot.parts.size() != std::size_t{strained} + std::size_t{pushed}) refuse_parts(snapshot);
    const StrainMemory strains = strains_of(snapshot, topology());
    const VecList pushes = local_ ? local_->pushes_of(snapshot) : VecList();
    do_reset(snapshot.state);
    dissipation_.reset(strains);
    if (local_) local_->reset(pushes);
    last_dt_ = snapshot.last_dt;
    steps_at_rest_ = snapshot.steps_at_rest;
  }

  void do_scene_changed() override {
    steps_at_rest_ = 0;
    follow_tools();
    scene().evaluate(state_.time, frame());
  }

  void do_values_changed() override {
    steps_at_rest_ = 0;
    scene().evaluate(state_.time, frame());
  }

  void do_body_changed(std::span<const Index> /*domains*/) override {
    for (Index i = 0; i < topology().particle_count; ++i) {
      if (topology().mass[i] > 0.0) continue;
      state_.position[i] = topology().rest[i];
      state_.velocity[i].setZero();
    }
  }

  void follow_tools() {
    tools_.follow(scene());
    ways_.reserve(tools_.count());
    touching_.follow(scene(), tools_.surface());
    shifts_.clear();
    if (!touches()) return;
    touched_.prepare(topology().mass, frame().fixed, topology().dimension == 2);
    shifts_.reserve(topology().rest.size());
    withheld_.reserve(topology().rest.size());
  }

  Motion do_step(const StepPlan& plan) override {
    if (!tools_.empty()) tools_.begin_call(scene(), plan.steps, plan.stop_at_rest);
    laps_.emplace(profiling());
    Motion motion = StepOrder::run(*this, plan);
    motion.strain = strain_summary(elastic(), state_.position);
    for (Index i = 0; i < topology().particle_count; ++i) {
      motion.max_displacement = std::max(motion.max_displacement, (state_.position[i] - topology().rest[i]).norm());
    }
    return motion;
  }

  // Stages of StepOrder.
  bool has_joints() { return !joints().empty(); }
  bool has_substeps() const { return local_.has_value(); }
  bool has_implicit_joints() { return stiff_joints() != nullptr && !stiff_joints()->empty(); }
  bool touches() const { return !tools_.empty() || !touching_.empty(); }
  void begin(const StepPlan& /*plan*/) {}
  void find_forces(const StepPlan& plan, bool /*last*/) {
    elastic_forces(elastic(), state_.position, force_);
    if (!dissipation_.empty()) dissipation_.add_forces(elastic(), state_.position, plan.dt, last_dt_, force_);
  }

  void limit(const StepPlan& plan) {
    laps_->end(forces_row_);
    cuts_ = cut_forces(plan.largest_acceleration);
    for (const JointSet::Point& point : joints().points()) force_[point.particle] += point.force;
  }

  void solve_joints(const StepPlan& plan) {
    solve_joints(
        plan, [this](Index i) { return acceleration(i); }, false);
  }

  void predict(const StepPlan& plan) {
    if (!touches()) return;
    shifts_.clear();
    for (std::size_t r = 0; r < local_f_.size(); ++r) local_f_[r] = force_[local_steps()->particle[r]];
    if (has_implicit_joints()) untouched_ = force_;
    integrate_all(plan);
    scene().evaluate(state_.time, frame());
  }

  /// The row of a volume that cannot be restored; -1: none.
  int touch(const StepPlan& plan) {
    Step step(*this);
    touched_.begin(step, plan.dt, last_dt_);
    tools_.act(touched_);
    const int lost = touching_.act(touched_);
    tools_.feel(touched_);
    touched_.end();
    if (local_) add_pushes();
    if (has_implicit_joints()) {
      solve_joints(
          plan, [this](Index i) -> Vec3 { return (force_[i] - untouched_[i]) / topology().mass[i]; }, true);
    }
    return lost;
  }

  /// The first particle that ran away; -1: none.
  Index move(const StepPlan& plan, Motion& motion) {
    measure(motion);
    laps_->end(checks_row_, 0);
    integrate_all(plan);
    laps_->end(move_row_);
    return first_runaway(plan.runaway_speed);
  }
  const char* settle() { return settled(joints(), stiff_joints(), tools_, touching_); }
  int& steps_at_rest() { return steps_at_rest_; }
  void drop_step() {
    tools_.drop();
    if (local_) local_->drop();
    scene().evaluate(state_.time, frame());
  }
  void accept(const StepPlan& plan, Motion& motion) {
    std::swap(state_.position, next_position_);
    std::swap(state_.velocity, next_velocity_);
    state_.time += plan.dt;
    if (!tools_.empty()) tools_.accept();
    touching_.accept(plan.dt);
    joints().accept();
    if (!dissipation_.empty()) dissipation_.accept();
    if (local_) local_->accept();
    last_dt_ = plan.dt;
    motion.force_clamped = motion.force_clamped || cuts_;
    motion.max_speed = max_free_speed();
    laps_->end(checks_row_);
  }
  RestThresholds rest_now(const StepPlan& plan, const Motion& /*motion*/) const {
    return with_flow(touching_.flow(), {plan.speed_at_rest, plan.acceleration_at_rest});
  }
  void do_read(State& state) const override {
    state = state_;
    tools_.read(scene(), state);
    touching_.read(scene(), state);
  }
  bool do_takes_tools() const override { return true; }
  const char* do_cannot() const override { return nullptr; }
  const ToolReport& do_tool_report(std::size_t row) const override { return tools_.report(scene().tools()[row]); }
  const ThreadState& do_thread_state(std::size_t row) const override { return tools_.thread(scene().threads()[row]); }
  const FluidState& do_fluid(std::size_t row) const override { return touching_.fluid(scene(), row); }
  double do_time() const override { return state_.time; }
  bool do_pass_time(double seconds) override { return (state_.time += seconds, true); }
  std::string do_device() const override { return "one processor core, double precision"; }
  ParticleBuffer do_position_buffer() const override { return {.position = state_.position}; }

  Energy do_energy() const override {
    DissipationNow dissipation = dissipation_at(elastic(), state_.position, dissipation_.memory(), last_dt_);
    Energy energy = energy_of(state_, last_dt_, substep_forces(read(), last_dt_, std::move(dissipation.force)));
    energy.elastic += dissipation.energy;
    return energy;
  }

  bool fixed(Index i, int axis) const { return !frame().fixed.empty() && (frame().fixed[i] >> axis & 1) != 0; }

  Vec3 acceleration(Index i) const {
    if (topology().mass[i] == 0.0) return Vec3::Zero();  // removed
    const Vec3 load = frame().force.empty() ? Vec3(Vec3::Zero()) : frame().force[i];
    return (force_[i] + load) / topology().mass[i] + frame().gravity;
  }

  bool cut_forces(double largest) {
    withheld_.clear();
    bool any = false;
    for (Index i = 0; i < topology().particle_count; ++i) {
      if (topology().mass[i] == 0.0) continue;
      const Vec3 uncut = force_[i], elastic = uncut / topology().mass[i];
      if (!(elastic.norm() > largest)) continue;
      force_[i] = topology().mass[i] * cut(elastic, largest);
      any = true;
      if (touches()) withheld_.push_back({i, uncut - force_[i]});
    }
    return any;
  }

  /// The step as tools see it: forces are those of force_, to which they add.
  class Step final : public PredictedStep {
   public:
    explicit Step(ReferenceSolver& solver) : solver_(solver) {}
    Vec3 position(Index i) const override { return solver_.state_.position[i]; }
    Vec3 predicted_velocity(Index i) const override { return solver_.next_velocity_[i]; }
    double going() const override { return longest_of_ways(solver_.state_.position, solver_.next_position_); }
    Vec3 withheld(Index i) const override {
      const auto own = std::ranges::lower_bound(solver_.withheld_, i, {}, &Withheld::particle);
      return own == solver_.withheld_.end() || own->particle != i ? Vec3(Vec3::Zero()) : own->force;
    }
    void find(const Region& region, std::vector<Index>& found) const override {
      for (Index i = 0; i < solver_.topology().particle_count; ++i) {
        if (region.meets(solver_.state_.position[i], solver_.next_position_[i])) found.push_back(i);
      }
    }
    void add_force(Index i, const Vec3& force) override { solver_.force_[i] += force; }
    void shift(Index i, const Vec3& by) override { solver_.shifts_.push_back({i, by}); }

   private:
    ReferenceSolver& solver_;
  };

  void pull_joints(const StepPlan& plan) {
    for (JointSet::Point& point : joints().points()) {
      point.position = state_.position[point.particle];
      point.velocity = state_.velocity[point.particle];
    }
    tools_.ways(plan.dt, ways_);
    joints().act(ways_, plan.dt);
  }

  /// Joints must have acted.
  void add_substeps(const StepPlan& plan) {
    const std::vector<Index>& particle = local_steps()->particle;
    for (const JointSet::Point& point : joints().points()) force_[point.particle] += point.force;
    for (std::size_t r = 0; r < particle.size(); ++r) {
      const Index i = particle[r];
      local_x_[r] = state_.position[i];
      local_a_[r] = acceleration(i);
      local_->imposed()[r] = tools_.held_by_any(i) ? 7 : frame().fixed.empty() ? 0 : frame().fixed[i];
    }
    for (const JointSet::Point& point : joints().points()) force_[point.particle] -= point.force;
    const std::span<const Vec3> change =
        local_->changes(local_x_, local_a_, plan.dt, local_steps()->factor(scene().stiffness_factors()));
    for (std::size_t r = 0; r < particle.size(); ++r) force_[particle[r]] += change[r];
  }

  /// Adds to force_ what the implicit joints change of the accelerations `of`(particle).
  template <class Of>
  void solve_joints(const StepPlan& plan, const Of& of, bool later) {
    for (StiffJoints::Reached& reached : stiff_joints()->reached()) {
      reached.acceleration = of(reached.particle);
      for (int axis = 0; axis < 3; ++axis) {
        if (fixed(reached.particle, axis)) reached.acceleration[axis] = 0.0;
      }
    }
    stiff_joints()->act(scene(), joints(), plan.dt, plan.damping_factor, later);
    for (const StiffJoints::Reached& reached : stiff_joints()->reached()) force_[reached.particle] += reached.force;
  }

  /// What tools and contacts have added since touch() began.
  void add_pushes() {
    const std::vector<Index>& particle = local_steps()->particle;
    const std::span<Vec3> pushes = local_->pushes();
    for (std::size_t r = 0; r < particle.size(); ++r) pushes[r] = force_[particle[r]] - local_f_[r];
  }

  /// Largest net force and acceleration on free coordinates, of the state before this step.
  void measure(Motion& motion) const {
    motion.max_acceleration = motion.max_force = 0.0;
    for (Index i = 0; i < topology().particle_count; ++i) {
      Vec3 a = acceleration(i);
      for (int axis = 0; axis < 3; ++axis) {
        if (fixed(i, axis)) a[axis] = 0.0;
      }
      motion.max_acceleration = std::max(motion.max_acceleration, a.norm());
      motion.max_force = std::max(motion.max_force, topology().mass[i] * a.norm());
    }
  }

  /// Forces act at the old time, imposed positions hold at the new one.
  void integrate_all(const StepPlan& plan) {
    for (Index i = 0; i < topology().particle_count; ++i) {
      const Moved<double> moved =
          integrate<double>(state_.position[i], state_.velocity[i], acceleration(i), plan.dt, plan.damping_factor);
      next_position_[i] = moved.position;
      next_velocity_[i] = moved.velocity;
    }
    for (const auto& [i, by] : shifts_) next_position_[i] += by;
    scene().evaluate(state_.time + plan.dt, frame());
    if (frame().fixed.empty()) return;
    for (Index i = 0; i < topology().particle_count; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        if (!fixed(i, axis)) continue;
        next_position_[i][axis] = frame().target[i][axis];
        next_velocity_[i][axis] = (frame().target[i][axis] - state_.position[i][axis]) / plan.dt;
      }
    }
  }

  Index first_runaway(double speed) const {
    for (Index i = 0; i < topology().particle_count; ++i) {
      if (!next_position_[i].allFinite() || !(next_velocity_[i].norm() <= speed)) return i;
    }
    return -1;
  }

  double max_free_speed() const {
    double largest = 0.0;
    for (Index i = 0; i < topology().particle_count; ++i) {
      Vec3 v = state_.velocity[i];
      for (int axis = 0; axis < 3; ++axis) v[axis] = fixed(i, axis) ? 0.0 : v[axis];
      largest = std::max(largest, v.norm());
    }
    return largest;
  }

  struct Withheld {
    Index particle;
    Vec3 force;  // N
  };

  State state_;
  std::vector<Withheld> withheld_;  // of this step, ascending; empty where nothing touches
  VecList force_, next_position_, next_velocity_;
  Dissipation dissipation_;
  std::optional<LocalForces> local_;
  VecList local_x_, local_a_, local_f_;  // m, m/s^2, N, for it
  VecList untouched_;                    // N, for implicit joints
  ToolSet tools_;
  std::vector<ToolWay> ways_;
  Touching touching_;
  TouchedParticles touched_;
  std::vector<std::pair<Index, Vec3>> shifts_;
  double last_dt_ = 0.0;
  int steps_at_rest_ = 0;
  bool cuts_ = false;                                   // some force in this step
  std::optional<Laps> laps_;                            // of the call
  int forces_row_ = 0, move_row_ = 0, checks_row_ = 0;  // of profiling()
};

}  // namespace

std::unique_ptr<Solver> make_reference_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                              const SolverOptions& options) {
  return std::make_unique<ReferenceSolver>(std::move(topology), scene, options);
}

}  // namespace phymul::cpu
