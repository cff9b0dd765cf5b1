// SPDX-License-Identifier: MIT
#include "simd_solver.h"

#include <phymul/backend.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "averaged_passes.h"
#include "base/denormals.h"
#include "base/thread_pool.h"
#include "body_sleep.h"
#include "cluster_claims.h"
#include "cpu/simd/instruction_set.h"
#include "device/float_range.h"
#include "near_displacements.h"
#include "packed_body.h"
#include "packed_dissipation.h"
#include "packed_joints.h"
#include "packed_loads.h"
#include "packed_local_steps.h"
#include "packed_state.h"
#include "packed_tools.h"
#include "part_summary.h"
#include "simd_profile.h"

namespace phymul::cpu {
namespace {

/// Bytes a step above which the next step finds hardly anything in a core's own caches.
constexpr double caches = 16e6;
/// And above which rows that a kernel reads once come from so far that it gains by asking for them ahead.
constexpr double near_caches = 8e6;

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
        claims_(*body_, pool_.parts()),
        summaries_(static_cast<std::size_t>(pool_.parts())),
        laps_(profiling(), *body_),
        no_laps_(nullptr, *body_),
        rows_far_(body_->bytes_a_step() > near_caches),
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
      if (options().sleep_tolerance && !dissipation_) sleep_.emplace(topology(), *body_, options().rest_steps);
    }
    if (body_->gives()) pull_.assign(quads, 0.0f);
    near_u_.assign(summaries_.size(), Floats(4 * body_->most_slots() + page, 0.0f));
    solve_stiff_joints();
    follow_scene_parts();
    begin_at_rest();
    tools_.reset(scene(), {});
  }

 private:
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
    take(snapshot.state, snapshot.displacement);
    if (dissipation_) dissipation_->reset(strains);
    if (local_) local_->forces().take(snapshot);
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
  bool do_takes_tools() const override { return true; }
  const char* do_cannot() const override { return nullptr; }
  const ToolReport& do_tool_report(std::size_t row) const override { return tools_.set().report(scene().tools()[row]); }

  Motion do_step(const StepPlan& plan) override {
    const DenormalsAreZero guard;
    Motion motion;
    motion.steps_at_rest = steps_at_rest_;
    laps_.begin();
    if (!tools_.empty()) tools_.set().begin_call(scene(), plan.steps, plan.stop_at_rest);
    while (motion.steps < plan.steps) {
      motion.lost_volume = step_once(plan, motion.steps + 1 == plan.steps);
      if (sleep_ && motion.lost_volume >= 0) sleep_->compute_all();
      if (motion.lost_volume >= 0) break;
      const simd::MoveSummary summary = moved();
      motion.max_acceleration = std::sqrt(static_cast<double>(summary.acceleration));
      motion.max_force = std::sqrt(static_cast<double>(summary.force));
      if (summary.runaway) {
        motion.bad_particle = first_runaway(*body_, next_u_, next_v_, plan.runaway_speed);
        if (sleep_) sleep_->compute_all();
        break;
      }
      if (sleep_) sleep_->accept();
      if (dissipation_) dissipation_->accept();
      if (local_) local_->forces().accept();
      u_.swap(next_u_);
      v_.swap(next_v_);
      if (!tools_.empty()) tools_.accept(summary, plan.dt);
      joints().accept();
      time_ += plan.dt;
      last_dt_ = plan.dt;
      ++motion.steps;
      motion.force_clamped = motion.force_clamped || summary.cut;

      motion.max_speed = std::sqrt(static_cast<double>(summary.speed));
      motion.max_displacement = std::sqrt(static_cast<double>(summary.displacement));
      const RestThresholds rest =
          rest_thresholds({plan.speed_at_rest, plan.acceleration_at_rest}, motion.max_displacement, plan.omega_max);
      const bool quiet = motion.max_speed <= rest.speed && motion.max_acceleration <= rest.acceleration;
      steps_at_rest_ = quiet ? steps_at_rest_ + 1 : 0;
      motion.steps_at_rest = steps_at_rest_;
      laps_.end(Work::checks);
      laps_.end_step(!tools_.empty());
      if (plan.stop_at_rest && steps_at_rest_ >= plan.rest_steps) break;
    }
    if (averaged_) {
      motion.strain.growth = 0.0;
      if (motion.steps == plan.steps) motion.strain = averaged_->strain(topology());
    }
    return motion;
  }

  /// The row of a volume that cannot be restored; -1: none.
  int step_once(const StepPlan& plan, bool last) {
    std::uint8_t* const changed = sleep_ ? sleep_->changed_loads() : nullptr;
    loads_.act_at(scene(), time_, changed);
    loads_.impose_at(scene(), time_ + plan.dt, changed);
    simd::Move move = move_of(plan);
    if (!tools_.empty()) tools_.ask(move);
    if (!joints().empty()) pulled_.act(joints(), tools_.set(), topology(), plan.dt, move, changed);
    if (sleep_) sleep_->begin(move, held_below(plan));
    laps_.end(Work::loads);
    const bool solves = stiff_joints() != nullptr && !stiff_joints()->empty();
    if (averaged_) {
      averaged_->run(bytes(force_), bytes(u_), bytes(next_u_),
                     dissipation_ ? dissipation_->job(plan.dt, last_dt_) : nullptr, sleep_ ? &*sleep_ : nullptr, last,
                     pool_, laps_);
      if (local_) local_->add_changes(move, scene().stiffness_factors(), bytes(force_));
      if (solves) pulled_.solve(*stiff_joints(), joints(), scene(), plan.dt, plan.damping_factor, bytes(force_), move);
      laps_.end(Work::averaged_forces);
    } else {
      clustered_forces();
    }
    run(move);
    if (tools_.empty()) return -1;
    const bool pushed = tools_.act(move, pool_, plan.dt, last_dt_, moved());
    if (local_) local_->keep_pushes(move, pushed ? tools_.loads() : nullptr);
    laps_.end(Work::tools);
    if (pushed) {
      if (sleep_) sleep_->push(tools_.pushed());
      if (solves) {
        pulled_.solve_pushes(*stiff_joints(), joints(), scene(), plan.dt, plan.damping_factor, move, tools_.loads());
      }
      move.load = tools_.loads();
      run(move);
    }
    tools_.shift(next_u_.data());
    for (const auto& shifted : tools_.shifts()) {
      if (sleep_) sleep_->shift(shifted.first);
    }
    laps_.end(Work::tools);
    return tools_.lost_volume();
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

  void clustered_forces() {
    claims_.begin();
    pool_.run([this](int part, int) {
      const DenormalsAreZero guard;
      for (int c = claims_.take(part); c >= 0; c = claims_.take(part)) elastic_forces_of(c, part);
    });
    laps_.end(Work::waiting);
  }

  void elastic_forces_of(int c, int part) {
    WorkLaps& laps = part == 0 ? laps_ : no_laps_;  // part 0 is the calling thread; the others write nothing
    const Cluster& cluster = body_->clusters[c];
    simd::Job job = cluster.job;
    if (body_->gives()) job.pull = bytes(pull_) + 16 * static_cast<std::size_t>(cluster.first);
    if (!force_.empty()) {
      job.force = bytes(force_) + 16 * cluster.force_first;
      std::memset(job.force, 0, 16 * static_cast<std::size_t>(cluster.slots()));
    }
    job.rows_far = rows_far_;
    job.far = far_;
    job.u = near_displacements(cluster, bytes(u_),
                               half_a_page_from(job.force ? job.force : job.pull, bytes(near_u_[part])));
    if (far_ && c + 1 < static_cast<int>(body_->clusters.size())) {
      ask_for_displacements(body_->clusters[c + 1], bytes(u_));
    }
    laps.end(Work::gathering);
    if (job.bases.count > 0) {
      kernels_.bases[static_cast<int>(body_->use)][body_->plane](job);
      laps.end(Work::bases);
    }
    if (job.enumerated.count > 0) {
      kernels_.enumerated[body_->use == simd::BaseUse::averaged](job);
      laps.end(Work::enumerated_bases);
    }
    if (job.springs.count > 0) {
      kernels_.springs(job);
      laps.end(Work::springs);
    }
    if (job.volumes.count > 0) {
      kernels_.volumes[body_->plane][body_->bounded](job);
      laps.end(Work::volumes);
    }
  }

  simd::Move move_of(const StepPlan& plan) {
    simd::Move move;
    move.force = force_.empty() ? nullptr : bytes(force_);
    move.own = body_->own.data();
    if (body_->clusters.size() > 1 && !force_.empty()) {
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
    constexpr double largest = std::numeric_limits<float>::max();
    move.runaway_squared = static_cast<float>(std::min(plan.runaway_speed * plan.runaway_speed, largest));
    move.largest_acceleration = static_cast<float>(std::min(plan.largest_acceleration, largest));
    move.largest_acceleration_squared =
        static_cast<float>(std::min(plan.largest_acceleration * plan.largest_acceleration, largest));
    return move;
  }

  void do_read(State& state) const override {
    state.time = time_;
    state.position.resize(body_->order.size());
    state.velocity.resize(body_->order.size());
    tools_.set().read(state);
    for (std::size_t place = 0; place < body_->order.size(); ++place) {
      const Index i = body_->order[place];
      state.position[i] = topology().rest[i] + displacement(*body_, u_, place);
      state.velocity[i] = velocity(*body_, v_, place);
    }
  }

  double do_time() const override { return time_; }

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
  std::unique_ptr<const PackedBody> body_;
  PackedLoads loads_;
  ThreadPool pool_;
  PackedTools tools_;
  PackedJoints pulled_;
  ClusterClaims claims_;
  std::optional<AveragedPasses> averaged_;  // of Law::particle_averaged
  std::optional<PackedLocalSteps> local_;   // of it
  std::optional<BodySleep> sleep_;
  std::optional<PackedDissipation> dissipation_;
  std::vector<PartSummary> summaries_;  // [parts]
  Floats u_, v_, next_u_, next_v_;      // u: [places + 1][4] by quad, v: [slices][3][lanes]
  Floats force_, pull_;
  std::vector<Floats> near_u_;  // [parts] displacements of the cluster a part is at
  double time_ = 0.0, last_dt_ = 0.0;
  int steps_at_rest_ = 0;
  WorkLaps laps_, no_laps_;
  const bool rows_far_, far_;
};

}  // namespace

std::unique_ptr<Solver> make_simd_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                         const SolverOptions& options) {
  return std::make_unique<SimdSolver>(std::move(topology), scene, options);
}

}  // namespace phymul::cpu
