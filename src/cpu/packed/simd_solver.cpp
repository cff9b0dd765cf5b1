// SPDX-License-Identifier: MIT
#include "cpu/cpu_backends.h"

#include <phymul/backend.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <optional>
#include <utility>

#include "base/denormals.h"
#include "base/thread_pool.h"
#include "body_sleep.h"
#include "cpu/simd/instruction_set.h"
#include "device/float_range.h"
#include "force_passes.h"
#include "packed_body.h"
#include "packed_dissipation.h"
#include "packed_loads.h"
#include "packed_local_steps.h"
#include "packed_tools.h"
#include "simd_profile.h"
#include "solver/step_order.h"

namespace phymul::cpu {
namespace {

/// Bytes a step above which the next step finds hardly anything in a core's own caches.
constexpr double caches = 16e6;

constexpr const char* sleep_part = "sleep";  // of a snapshot

class SimdSolver final : public SolverBackend {
 public:
  SimdSolver(std::shared_ptr<const TopologyTextures> shared, const Scene& scene_in, const SolverOptions& options_in)
      : SolverBackend("cpu", std::move(shared), scene_in, options_in),
        kernels_(simd::chosen_kernels()),
        body_(make_packed_body(topology(), kernels_.lanes)),
        loads_(scene(), *body_),
        pool_(body_->threads_for(options().threads, options().runner.get()), options().runner.get()),
        tools_(*body_, topology(), pool_.parts()),
        summaries_(static_cast<std::size_t>(pool_.parts())),
        laps_(profiling(), *body_),
        no_laps_(nullptr, *body_),
        far_(body_->bytes_a_step() > caches) {
    const auto quads = 4 * (static_cast<std::size_t>(std::max(body_->places, body_->averages.slots)) + 1);
    u_.assign(quads, 0.0f);
    next_u_ = u_;
    v_.assign(3 * static_cast<std::size_t>(body_->places), 0.0f);
    next_v_ = v_;
    force_.assign(4 * static_cast<std::size_t>(body_->force_rows), 0.0f);
    if (body_->averaged()) {
      averaged_.emplace(topology(), *body_, kernels_, pool_.parts());
      if (local_steps() != nullptr) local_.emplace(*local_steps(), *body_);
      if (!topology().dissipation.empty()) dissipation_.emplace(topology(), body_->averages);
      const bool sleeps = options().sleep_tolerance && !dissipation_ && topology().walls.empty();
      if (sleeps) sleep_.emplace(topology(), *body_, options().rest_steps);
    }
    if (!body_->clusters.empty()) clustered_.emplace(*body_, kernels_, pool_.parts(), far_);
    if (body_->gives()) pull_.assign(quads, 0.0f);
    solve_stiff_joints();
    follow_scene_parts();
    begin_at_rest();
    tools_.reset(scene(), {});
  }

 private:
  friend StepOrder;
  void do_reset(const State& state) override { take(state, {}); }

  void do_snapshot(Snapshot& snapshot) const override {
    do_read(snapshot.state);
    snapshot.displacement.resize(body_->order.size());
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      snapshot.displacement[body_->order[place]] = displacement(*body_, u_, place);
    }
    snapshot.last_dt = last_dt_;
    snapshot.steps_at_rest = steps_at_rest_;
    if (dissipation_) put_strains(dissipation_->memory(), snapshot);
    if (local_) local_->forces().put(snapshot);
    if (!sleep_) return;
    if (auto memory = sleep_->memory(); !memory.empty()) snapshot.parts.push_back({sleep_part, std::move(memory)});
  }

  void do_restore(const Snapshot& snapshot) override {
    const bool slept = snapshot.parts.size() == 1 && snapshot.parts.front().name == sleep_part;
    const bool strained = dissipation_ && has_strains(snapshot), pushed = local_ && LocalForces::has(snapshot);
    const bool known = slept || snapshot.parts.size() == std::size_t{strained} + std::size_t{pushed};
    if (!known) refuse_parts(snapshot);
    if (sleep_ && slept) sleep_->require_fitting(snapshot.parts.front().bytes);
    const StrainMemory strains = strains_of(snapshot, topology());
    const VecList pushes = local_ ? local_->forces().pushes_of(snapshot) : VecList();
    take(snapshot.state, snapshot.displacement);
    if (dissipation_) dissipation_->reset(strains);
    if (local_) local_->forces().reset(pushes);
    if (sleep_ && slept) sleep_->remember(snapshot.parts.front().bytes);
    last_dt_ = snapshot.last_dt;
    steps_at_rest_ = snapshot.steps_at_rest;
  }

  /// Displacements are those of the state where none are given.
  void take(const State& state, const VecList& given) {
    require_state_in_range(topology().rest, state, given);
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      const Index i = body_->order[place];
      const Vec3 u = given.empty() ? Vec3(state.position[i] - topology().rest[i]) : given[i];
      for (int a = 0; a < 3; ++a) {
        u_[4 * body_->quad_of(place) + a] = static_cast<float>(u[a]);
        v_[velocity_at(*body_, place, a)] = static_cast<float>(state.velocity[i][a]);
      }
    }
    tools_.reset(scene(), state);
    time_ = state.time;
    last_dt_ = 0.0;
    steps_at_rest_ = 0;
    if (sleep_) sleep_->wake_all();
    if (dissipation_) dissipation_->reset({});
    if (local_) local_->forces().reset();
  }

  void do_scene_changed() override {
    steps_at_rest_ = 0;
    if (sleep_) sleep_->compute_all();
    loads_ = PackedLoads(scene(), *body_);
    follow_scene_parts();
  }

  void do_body_changed(std::span<const Index> domains) override {
    if (body_->edit(topology(), domains)) averaged_.reset();
    if (body_->averaged() && !averaged_) averaged_.emplace(topology(), *body_, kernels_, pool_.parts());
    if (!topology().walls.empty()) {
      force_.assign(4 * static_cast<std::size_t>(body_->force_rows), 0.0f);
      clustered_.emplace(*body_, kernels_, pool_.parts(), far_);
    }
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      if (topology().mass[body_->order[place]] > 0.0) continue;
      for (int a = 0; a < 3; ++a) {
        u_[4 * body_->quad_of(place) + a] = next_u_[4 * body_->quad_of(place) + a] = 0.0f;
        v_[velocity_at(*body_, place, a)] = 0.0f;
      }
    }
    if (sleep_) sleep_.emplace(topology(), *body_, options().rest_steps);  // others reach each other now
  }

  void follow_scene_parts() {
    if (averaged_) averaged_->scale(topology(), scene().stiffness_factors());
    tools_.follow(scene(), frame().fixed);
    pulled_.follow(joints(), stiff_joints(), tools_.set(), *body_);
  }

  void do_values_changed() override {
    steps_at_rest_ = 0;
    const bool changed = averaged_ && averaged_->scale(topology(), scene().stiffness_factors());
    if (changed && sleep_) sleep_->compute_all();
  }
  static char* bytes_or_null(Floats& floats) { return floats.empty() ? nullptr : bytes(floats); }
  bool do_takes_tools() const override { return true; }
  const char* do_cannot() const override { return nullptr; }
  const ToolReport& do_tool_report(std::size_t row) const override { return tools_.set().report(scene().tools()[row]); }
  const ThreadState& do_thread_state(std::size_t row) const override {
    return tools_.set().thread(scene().threads()[row]);
  }
  const FluidState& do_fluid(std::size_t row) const override { return tools_.fluid(scene(), row); }

  Motion do_step(const StepPlan& plan) override {
    const DenormalsAreZero guard;
    laps_.begin();
    if (!tools_.empty()) tools_.set().begin_call(scene(), plan.steps, plan.stop_at_rest);
    Motion motion = StepOrder::run(*this, plan);
    const bool rests = plan.stop_at_rest && steps_at_rest_ >= options().rest_steps;
    const bool at_end = plan.steps > 0 && (rests || motion.steps == plan.steps);
    if (!at_end) motion.strain.growth = 0.0;
    if (at_end && averaged_) motion.strain = averaged_->strain(topology());
    if (at_end && !averaged_ && clustered_) motion.strain.growth = clustered_->growth(topology());
    return motion;
  }

  // Stages of StepOrder. The kernel that moves limits forces too, and predicts: where something touches, it runs again.

  bool has_joints() { return !joints().empty(); }
  bool has_substeps() const { return local_.has_value(); }
  bool has_implicit_joints() { return averaged_ && stiff_joints() != nullptr && !stiff_joints()->empty(); }
  bool touches() const { return !tools_.empty(); }
  std::uint8_t* changed_loads() { return sleep_ ? sleep_->changed_loads() : nullptr; }

  void begin(const StepPlan& plan) {
    loads_.act_at(scene(), time_, changed_loads());
    loads_.impose_at(scene(), time_ + plan.dt, changed_loads());
    move_ = move_of(plan);
    if (touches()) tools_.ask(move_);
    pushed_ = false;
  }

  void pull_joints(const StepPlan& plan) {
    pulled_.act(joints(), tools_.set(), topology(), plan.dt, move_, changed_loads());
  }

  void find_forces(const StepPlan& plan, bool last) {
    if (sleep_) sleep_->begin(move_, held_below(plan));
    laps_.end(Work::loads);
    if (averaged_) {
      averaged_->run(bytes(force_), bytes(u_), bytes(next_u_),
                     dissipation_ ? dissipation_->job(plan.dt, last_dt_) : nullptr, sleep_ ? &*sleep_ : nullptr,
                     last || plan.stop_at_rest || sleep_, pool_, laps_);
    }
    if (!clustered_) return;
    clustered_->run(bytes(u_), bytes_or_null(force_), bytes_or_null(pull_), last || plan.stop_at_rest, pool_, laps_,
                    no_laps_);
    if (averaged_) clustered_->add_to_particles(bytes(force_), laps_);
  }

  void add_substeps(const StepPlan& /*plan*/) {
    local_->add_changes(move_, tools_.set(), scene().stiffness_factors(), bytes(force_));
  }

  void limit(const StepPlan& /*plan*/) {}

  void solve_joints(const StepPlan& plan) {
    pulled_.solve(*stiff_joints(), joints(), scene(), plan.dt, plan.damping_factor, bytes(force_), move_);
  }

  void predict(const StepPlan& /*plan*/) {
    if (averaged_) laps_.end(Work::averaged_forces);
    run(move_);
  }

  /// The row of a volume that cannot be restored; -1: none.
  int touch(const StepPlan& plan) {
    pushed_ = tools_.act(move_, pool_, plan.dt, last_dt_, moved(), laps_);
    if (local_) local_->keep_pushes(move_, pushed_ ? tools_.loads() : nullptr);
    return tools_.lost_volume();
  }

  /// The first particle that ran away; -1: none.
  Index move(const StepPlan& plan, Motion& motion) {
    if (pushed_) {
      if (sleep_) sleep_->push(tools_.pushed());
      if (has_implicit_joints()) {
        pulled_.solve_pushes(*stiff_joints(), joints(), scene(), plan.dt, plan.damping_factor, move_, tools_.loads());
      }
      move_.load = tools_.loads();
      run(move_);
    }
    if (touches()) {
      tools_.shift(next_u_.data());
      for (const auto& shifted : tools_.shifts()) {
        if (sleep_) sleep_->shift(shifted.first);
      }
      laps_.end(tools_.set().empty() ? Work::contacts : Work::tools);
    }
    summary_ = moved();
    motion.max_acceleration = std::sqrt(static_cast<double>(summary_.acceleration));
    motion.max_force = std::sqrt(static_cast<double>(summary_.force));
    return summary_.runaway ? first_runaway(*body_, next_u_, next_v_, plan.runaway_speed) : -1;
  }

  const char* settle() { return tools_.settle(joints(), stiff_joints()); }
  int& steps_at_rest() { return steps_at_rest_; }
  void drop_step() {
    tools_.set().drop();
    if (local_) local_->forces().drop();
    if (sleep_) sleep_->compute_all();
  }

  void accept(const StepPlan& plan, Motion& motion) {
    if (sleep_) sleep_->accept();
    if (dissipation_) dissipation_->accept();
    if (local_) local_->forces().accept();
    u_.swap(next_u_);
    v_.swap(next_v_);
    if (touches()) tools_.accept(summary_, plan.dt);
    joints().accept();
    time_ += plan.dt;
    last_dt_ = plan.dt;
    motion.force_clamped = motion.force_clamped || summary_.cut;
    motion.max_speed = std::sqrt(static_cast<double>(summary_.speed));
    motion.max_displacement = std::sqrt(static_cast<double>(summary_.displacement));
    laps_.end(Work::checks);
    laps_.end_step(!tools_.set().empty(), tools_.touches());
  }

  RestThresholds rest_now(const StepPlan& plan, const Motion& motion) const {
    const RestThresholds in_double{plan.speed_at_rest, plan.acceleration_at_rest};
    return with_flow(tools_.flow(), rest_thresholds(in_double, motion.max_displacement, plan.omega_max));
  }

  simd::MoveSummary moved() const { return sleep_ ? sleep_->summary() : summary_of(summaries_); }

  /// run_to_rest() seeks a rest closer than a body is held by, so that nothing is held then.
  RestThresholds held_below(const StepPlan& plan) const {
    const double share = plan.stop_at_rest ? 0.0 : *options().sleep_tolerance / options().rest_tolerance;
    return {share * plan.speed_at_rest, share * plan.acceleration_at_rest};
  }

  void run(const simd::Move& move) {
    if (sleep_) {
      sleep_->move(move, kernels_, pool_);
      laps_.end(Work::move);
      return;
    }
    pool_.run([&, this](int part, int parts) {
      const DenormalsAreZero guard;
      const auto bound = [&](int k) { return static_cast<int>(std::int64_t{body_->slices()} * k / parts); };
      kernels_.move(move, bound(part), bound(part + 1), summaries_[part].summary);
    });
    laps_.end(Work::move);
  }

  simd::Move move_of(const StepPlan& plan) {
    simd::Move move;
    move.force = bytes_or_null(force_);
    move.own = body_->own.data();
    if (body_->clusters.size() > 1 && !force_.empty() && !averaged_) {
      move.halo_first = body_->halo_first.data();
      move.halo = body_->halo.data();
    }
    if (body_->gives()) {
      move.pull = bytes(pull_);
      move.give_first = body_->give_first.data();
      move.give = body_->give.data();
    }
    loads_.point(move);
    move.inverse_mass = body_->inverse_mass.data();
    move.mass = body_->mass.data();
    move.u = bytes(u_);
    move.far = far_;
    move.slices = body_->slices();
    move.v = v_.data();
    move.next_u = bytes(next_u_);
    move.next_v = next_v_.data();
    move.dt = static_cast<float>(plan.dt);
    move.inverse_dt = static_cast<float>(1.0 / plan.dt);
    move.damping = static_cast<float>(plan.damping_factor);
    const auto bounded = [](double x) { return static_cast<float>(std::min<double>(x, FLT_MAX)); };
    move.runaway_squared = bounded(plan.runaway_speed * plan.runaway_speed);
    move.largest_acceleration = bounded(plan.largest_acceleration);
    move.largest_acceleration_squared = bounded(plan.largest_acceleration * plan.largest_acceleration);
    return move;
  }

  void do_read(State& state) const override {
    state.time = time_;
    state.position.resize(body_->order.size());
    state.velocity.resize(body_->order.size());
    tools_.read(scene(), state);
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      const Index i = body_->order[place];
      state.position[i] = topology().rest[i] + displacement(*body_, u_, place);
      state.velocity[i] = velocity(*body_, v_, place);
    }
  }
  double do_time() const override { return time_; }
  bool do_pass_time(double seconds) override { return (time_ += seconds, true); }
  std::string do_device() const override {
    return std::to_string(pool_.parts()) + (pool_.parts() == 1 ? " thread" : " threads") + ", " + kernels_.name +
           " vectors, single precision";
  }
  Energy do_energy() const override {
    const State state = read();
    DissipationNow now;
    if (dissipation_) now = dissipation_at(elastic(), state.position, dissipation_->memory(), last_dt_);
    Energy energy = energy_of(state, last_dt_, substep_forces(state, last_dt_, std::move(now.force)));
    energy.elastic += now.energy;
    return energy;
  }

  const simd::Kernels& kernels_;
  std::unique_ptr<PackedBody> body_;
  PackedLoads loads_;
  ThreadPool pool_;
  PackedTools tools_;
  PackedJoints pulled_;
  std::optional<ClusteredPasses> clustered_;  // of walls, and of any other law
  std::optional<AveragedPasses> averaged_;    // of Law::particle_averaged
  std::optional<PackedLocalSteps> local_;     // of it
  std::optional<BodySleep> sleep_;
  std::optional<PackedDissipation> dissipation_;
  std::vector<PartSummary> summaries_;  // [parts]
  Floats u_, v_, next_u_, next_v_;      // u: [places + 1][4] by quad, v: [slices][3][lanes]
  Floats force_, pull_;
  double time_ = 0.0, last_dt_ = 0.0;
  int steps_at_rest_ = 0;
  simd::Move move_;  // of the step in question, as the next two
  simd::MoveSummary summary_;
  bool pushed_ = false;
  WorkLaps laps_, no_laps_;
  const bool far_;
};

}  // namespace

std::unique_ptr<Solver> make_simd_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                         const SolverOptions& options) {
  return std::make_unique<SimdSolver>(std::move(topology), scene, options);
}

}  // namespace phymul::cpu
