// SPDX-License-Identifier: MIT
#include "mirror.h"

#include <phymul/backend.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "device/float_range.h"
#include "kernels.h"
#include "mirror_forces.h"
#include "mirror_scene.h"
#include "scene/tool_state.h"
#include "solver/step_order.h"

namespace phymul::cpu {
namespace {

using Step = Kernels<float>;

Float3 narrowed(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Vec3 widened(const Float3& v) {
  return {v.x, v.y, v.z};
}

bool is_finite(const Float3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// A scene in float: vectors that stay, and their factors at one instant.
class FloatLoads {
 public:
  explicit FloatLoads(const Scene& scene)
      : modes_(scene.modes()), exact_(static_cast<std::size_t>(modes_.count)), value_(exact_.size()) {
    for (const auto& part : modes_.target) target_.push_back(narrowed(part.vector));
    for (const auto& part : modes_.force) force_.push_back(narrowed(part.vector));
  }

  void evaluate(const Scene& scene, double time) {
    scene.mode_values(time, exact_);
    std::ranges::transform(exact_, value_.begin(), [](double value) { return static_cast<float>(value); });
    Vec3 sum = modes_.gravity;
    for (const LoadModes::Part& part : modes_.acceleration) sum += exact_[part.mode] * part.vector;
    gravity = narrowed(sum);
  }

  bool imposes() const { return !modes_.fixed.empty(); }
  bool fixed(Index i, int axis) const { return imposes() && (modes_.fixed[i] >> axis & 1) != 0; }
  Float3 target(Index i) const {
    return modes_.target_offset.empty() ? Float3{} : sum(modes_.target_offset, modes_.target, target_, i);
  }
  bool pushes() const { return !modes_.force_offset.empty(); }
  Float3 force(Index i) const { return sum(modes_.force_offset, modes_.force, force_, i); }

  /// What is left of a vector on coordinates that nothing holds.
  Float3 free_part(Index i, const Float3& v) const {
    return {fixed(i, 0) ? 0.0f : v.x, fixed(i, 1) ? 0.0f : v.y, fixed(i, 2) ? 0.0f : v.z};
  }

  Float3 gravity;

 private:
  Float3 sum(const std::vector<Index>& offset, const std::vector<LoadModes::Part>& parts,
             const std::vector<Float3>& vector, Index i) const {
    Float3 total;
    for (Index row = offset[i]; row < offset[i + 1]; ++row) total += value_[parts[row].mode] * vector[row];
    return total;
  }

  LoadModes modes_;
  std::vector<double> exact_;
  std::vector<float> value_;
  std::vector<Float3> target_, force_;
};

class MirrorSolver final : public SolverBackend {
 public:
  MirrorSolver(std::shared_ptr<const TopologyTextures> shared, const Scene& scene_in, const SolverOptions& options_in,
               FloatLayout layout)
      : SolverBackend("mirror", std::move(shared), scene_in, options_in),
        forces_(pack_floats(topology(), layout)),
        dissipation_(topology(), forces_.tables().domains.source),
        loads_(scene()),
        u_(topology().rest.size()),
        v_(u_.size()),
        next_u_(u_.size()),
        next_v_(u_.size()),
        force_(u_.size()),
        withheld_(u_.size()) {
    follow();
    reset();
  }

 private:
  friend StepOrder;

  void do_reset(const State& state) override {
    require_state_in_range(topology().rest, state);
    for (std::size_t i = 0; i < u_.size(); ++i) {
      u_[i] = narrowed(state.position[i] - topology().rest[i]);
      v_[i] = narrowed(state.velocity[i]);
    }
    tools_.reset(scene(), state);
    dissipation_.reset();
    time_ = state.time;
    last_dt_ = 0.0;
    steps_at_rest_ = 0;
  }

  void do_scene_changed() override {
    steps_at_rest_ = 0;
    loads_ = FloatLoads(scene());
    follow();
  }

  void follow() {
    tools_.follow(scene());
    volumes_.follow(scene());
    joints_.follow(scene(), tools_);
    forces_.scale(scene().stiffness_factors());
  }

  void do_values_changed() override {
    steps_at_rest_ = 0;
    forces_.scale(scene().stiffness_factors());
  }
  const char* do_cannot() const override {
    if (has_needle(scene().tools()) || scene().contacts()) return "the mirror has no needles and no contacts";
    if (touches_surface(scene().tools())) return "the mirror has no tools with ToolContact::surface";
    return beyond_devices();
  }
  bool do_takes_tools() const override { return true; }
  bool do_takes_volumes() const override { return true; }
  const ToolReport& do_tool_report(std::size_t row) const override { return tools_.report(scene().tools()[row]); }

  Motion do_step(const StepPlan& plan) override {
    if (tools_.begin_call(scene(), plan.steps, plan.stop_at_rest)) {
      tools_.hold(read().position, frame().fixed, topology().dimension == 2);
    }
    return StepOrder::run(*this, plan);
  }

  // Stages of StepOrder. Particle by particle, as the shaders do it, the rest is one.

  static bool has_joints() { return false; }
  static bool has_substeps() { return false; }
  static bool has_implicit_joints() { return false; }
  static bool touches() { return false; }
  void begin(const StepPlan& plan) {
    if (!dissipation_.empty()) dissipation_.begin_step(plan.dt, last_dt_);
  }
  static void pull_joints(const StepPlan& /*plan*/) {}
  static void find_forces(const StepPlan& /*plan*/, bool /*last*/) {}
  static void add_substeps(const StepPlan& /*plan*/) {}
  static void limit(const StepPlan& /*plan*/) {}
  static void solve_joints(const StepPlan& /*plan*/) {}
  static void predict(const StepPlan& /*plan*/) {}
  static int touch(const StepPlan& /*plan*/) { return -1; }

  Index move(const StepPlan& plan, Motion& motion) {
    cuts_ = move_all(plan, motion);
    return motion.lost_volume >= 0 ? -1 : first_runaway(plan.runaway_speed);
  }

  static const char* settle() { return ""; }
  int& steps_at_rest() { return steps_at_rest_; }
  static void drop_step() {}

  void accept(const StepPlan& plan, Motion& motion) {
    u_.swap(next_u_);
    v_.swap(next_v_);
    accept_joints_and_tools(plan.dt);
    dissipation_.accept();
    time_ += plan.dt;
    last_dt_ = plan.dt;
    motion.force_clamped = motion.force_clamped || cuts_;
    motion.max_speed = max_free_speed();
  }

  RestThresholds rest_now(const StepPlan& plan, const Motion& /*motion*/) const {
    const RestThresholds asked{plan.speed_at_rest, plan.acceleration_at_rest};
    return joints_.empty() ? rest_thresholds(asked, largest_displacement())
                           : rest_thresholds(asked, largest_displacement(), plan.omega_max);
  }

  void accept_joints_and_tools(double dt) {
    std::vector<JointSet::Pull> sums(scene().tools().size());
    if (!joints_.empty()) {
      joints().take(joints_.told(), sums);
      joints().accept();
    }
    if (!tools_.empty()) tools_.accept(1, dt, tool_sums_, sums, sums);
  }

  void do_read(State& state) const override {
    state.time = time_;
    tools_.read(scene(), state);
    state.position.resize(u_.size());
    state.velocity.resize(u_.size());
    for (std::size_t i = 0; i < u_.size(); ++i) {
      state.position[i] = topology().rest[i] + widened(u_[i]);
      state.velocity[i] = widened(v_[i]);
    }
  }

  double do_time() const override { return time_; }
  std::string do_device() const override { return "one processor core, single precision"; }

  Energy do_energy() const override { return energy_of(read(), last_dt_); }

  /// Forces act at the old time, imposed positions hold at the new one. True where an elastic force was cut.
  bool move_all(const StepPlan& plan, Motion& motion) {
    if (!tools_.empty()) tools_.begin_batch(1, plan.dt);
    const auto inverse_dt = static_cast<float>(1.0 / plan.dt);
    if (!joints_.empty()) joints_.act({u_, v_, inverse_dt, plan.stop_at_rest}, joints());
    const bool any_cut = net_forces(static_cast<float>(plan.largest_acceleration));
    const Float3 gravity = loads_.gravity;
    if (loads_.imposes()) loads_.evaluate(scene(), time_ + plan.dt);
    tool_sums_.assign(static_cast<std::size_t>(tools_.count()), ToolSums{});
    motion.max_acceleration = motion.max_force = 0.0;
    for (Index i = 0; i < topology().particle_count; ++i) {
      Displaced moved = free_step(plan, i, gravity);
      if (!tools_.empty()) moved = touched_step(plan, i, gravity, moved.v);
      next_u_[i] = moved.u;
      next_v_[i] = moved.v;
    }
    if (!volumes_.empty()) motion.lost_volume = find_ways();
    for (Index i = 0; i < topology().particle_count; ++i) {
      Float3 a = Step::acceleration(force_[i], forces_.tables().particle[i][0], gravity);
      if (volumes_.moves(i)) go_along(i, inverse_dt, a);
      const double free = widened(loads_.free_part(i, a)).norm();
      motion.max_acceleration = std::max(motion.max_acceleration, free);
      motion.max_force = std::max(motion.max_force, topology().mass[i] * free);
    }
    return any_cut;
  }

  /// Of the particles of kept volumes. The row of a volume that cannot be kept; -1: none.
  int find_ways() {
    volumes_.follow_gradient(u_, forces_.tables().particle, [this](Index i) {
      if (!tools_.empty() && tools_.held()[static_cast<std::size_t>(i)][3] >= 0.0f) return 7;
      return fixed_axes(i);
    });
    return volumes_.find_roots(next_u_);
  }

  void go_along(Index i, float inverse_dt, Float3& a) {
    const auto [way, along] = volumes_.way(i);
    const float speed = inverse_dt * way;
    next_u_[i] += way * along;
    next_v_[i] += speed * along;
    a += (inverse_dt * speed) * along;
  }

  int fixed_axes(Index i) const {
    int fixed_at = 0;
    for (int axis = 0; axis < 3; ++axis) fixed_at |= loads_.fixed(i, axis) ? 1 << axis : 0;
    return fixed_at;
  }

  /// Into force_. True where an elastic force was cut.
  bool net_forces(float largest_acceleration) {
    forces_.evaluate(u_, force_, dissipation_.empty() ? nullptr : &dissipation_);
    loads_.evaluate(scene(), time_);
    bool any_cut = false;
    for (Index i = 0; i < topology().particle_count; ++i) {
      const Float3 cut = Step::cut_force(force_[i], forces_.tables().particle[i][2] * largest_acceleration);
      any_cut = any_cut || cut != force_[i];
      withheld_[i] = force_[i] - cut;
      force_[i] = loads_.pushes() ? cut + loads_.force(i) : cut;
      if (!joints_.empty()) joints_.add_forces(i, force_[i]);
    }
    return any_cut;
  }

  struct Displaced {
    Float3 u, v;
  };

  Displaced free_step(const StepPlan& plan, Index i, const Float3& gravity) const {
    const Float3 a = Step::acceleration(force_[i], forces_.tables().particle[i][0], gravity);
    Displaced moved{u_[i], v_[i]};
    Step::integrate_displacement(moved.u, moved.v, a, static_cast<float>(plan.dt),
                                 static_cast<float>(plan.damping_factor));
    if (loads_.imposes()) {
      Step::impose(moved.u, moved.v, fixed_axes(i), loads_.target(i), u_[i], static_cast<float>(1.0 / plan.dt));
    }
    return moved;
  }

  /// Adds to force_ what tools do to a particle that would go on with velocity v.
  Displaced touched_step(const StepPlan& plan, Index i, const Float3& gravity, const Float3& v) {
    const auto dt = static_cast<float>(plan.dt), inverse_dt = static_cast<float>(1.0 / plan.dt);
    const ToolRows rows(tools_);
    const int fixed_at = fixed_axes(i) | (topology().dimension == 2 ? 4 : 0);
    TouchedParticle particle = rows.untouched(i, u_[i], v, forces_.tables().particle[i], fixed_at);
    particle.withheld = withheld_[i];
    for (int tool = 0; tool < tools_.count(); ++tool) {
      add(rows.touch(tool, i, particle, dt, inverse_dt), tool_sums_[static_cast<std::size_t>(tool)]);
    }
    force_[i] += inverse_dt * particle.impulse;
    Displaced moved = free_step(plan, i, gravity);
    moved.u += particle.shift;
    return moved;
  }

  /// Of one step.
  static void add(const FloatReaction& reaction, ToolSums& sums) {
    if (!reaction.touches) return;
    const auto add_to = [](Float4& sum, const Float3& v) { sum = {sum[0] + v.x, sum[1] + v.y, sum[2] + v.z, sum[3]}; };
    add_to(sums.force, reaction.force);
    add_to(sums.torque, reaction.torque);
    add_to(sums.last_force, reaction.force);
    add_to(sums.last_torque, reaction.torque);
    sums.last_force[3] += 1.0f;
  }

  Index first_runaway(double speed) const {
    for (Index i = 0; i < topology().particle_count; ++i) {
      if (!is_finite(next_u_[i]) || !(widened(next_v_[i]).norm() <= speed)) return i;
    }
    return -1;
  }

  double max_free_speed() const {
    double largest = 0.0;
    for (Index i = 0; i < topology().particle_count; ++i) {
      largest = std::max(largest, widened(loads_.free_part(i, v_[i])).norm());
    }
    return largest;
  }

  double largest_displacement() const {
    double largest = 0.0;
    for (const Float3& u : u_) largest = std::max(largest, widened(u).norm());
    return largest;
  }

  MirrorForces forces_;
  MirrorDissipation dissipation_;
  FloatLoads loads_;
  FloatTools tools_{1};
  MirrorVolumes volumes_;
  MirrorJoints joints_;
  std::vector<ToolSums> tool_sums_;  // of the step in question
  std::vector<Float3> u_, v_, next_u_, next_v_, force_, withheld_;
  double time_ = 0.0, last_dt_ = 0.0;
  int steps_at_rest_ = 0;
  bool cuts_ = false;
};

}  // namespace

std::unique_ptr<Solver> make_mirror_solver(std::shared_ptr<const TopologyTextures> topology, const Scene& scene,
                                           const SolverOptions& options, FloatLayout layout) {
  return std::make_unique<MirrorSolver>(std::move(topology), scene, options, layout);
}

}  // namespace phymul::cpu
