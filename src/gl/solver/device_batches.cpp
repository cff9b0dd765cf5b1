// SPDX-License-Identifier: MIT
//
// The steps of DeviceSolver: batch by batch, each with a report at its end.
#include <algorithm>
#include <array>
#include <chrono>

#include "device/float_range.h"
#include "device/float_scene.h"
#include "device_solver.h"
#include "solver/step_order.h"

namespace phymul::gl {
namespace {

/// A batch of steps that takes longer keeps the device from drawing, and a window system may take it for hung.
constexpr double seconds_a_batch = 0.05;
constexpr double first_batch = 8.0;  // steps, before it is known how long one takes

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The steps of DeviceSolver where something acts on the host: one by one while it may touch the body, else in batches,
// in which nothing is read. That nothing was in reach rests on a bound of the body's motion, which a batch reports if a
// particle breaks it: its steps before that one count.

/// Times what particles do now: room for what they may do before the next look.
constexpr double faster = 3.0;

constexpr std::array batches{64, 16, 4};  // steps

}  // namespace

/// No longer than rest_steps where the body is to stop at rest: then an unquiet step in a batch says that no other
/// row of so many quiet ones is in it.
int DeviceSolver::batch_size(const StepPlan& plan, int remaining) const {
  const double wished = seconds_a_step_ > 0.0 ? seconds_a_batch / seconds_a_step_ : first_batch;
  const int size = static_cast<int>(std::clamp(wished, 1.0, static_cast<double>(Device::most_steps)));
  return std::min({size, remaining, plan.stop_at_rest ? plan.rest_steps : remaining});
}

/// New poses and grasps of a call. What is grasped is found here, from one read of the state; steps read nothing.
void DeviceSolver::begin_tools(const StepPlan& plan) {
  if (tools_.empty() || !tools_.begin_call(scene(), plan.steps, plan.stop_at_rest)) return;
  State now;
  if (tools_.grasps()) device_->read(topology().rest, now);
  tools_.hold(now.position, frame().fixed, topology().dimension == 2);
  device_->set_held(tools_);
}

void DeviceSolver::begin_joints() {
  if (joints_told_ || joints().empty()) return;
  device_->write_joints(joint_rows(scene().joints(), joints()));
  joints_told_ = true;
}

SolverBackend::Motion DeviceSolver::run_batches(const StepPlan& plan) {
  if (!host_) begin_tools(plan);
  begin_joints();
  if (dissipation_ && plan.dt != dissipation_dt_) {
    device_->set_dissipation(dissipation_->constants(plan.dt));
    dissipation_dt_ = plan.dt;
  }
  const PassTimer::Current timing(device_->timer());
  if (host_) return run_on_host(plan);
  Motion motion;
  motion.steps_at_rest = progress_.steps_at_rest;
  while (motion.steps < plan.steps) {
    const int count = batch_size(plan, plan.steps - motion.steps);
    const auto start = std::chrono::steady_clock::now();
    const bool go_on = run_batch(plan, count, motion);
    if (*motion.not_finite == '\0') seconds_a_step_ = seconds_since(start) / count;
    progress_.steps_at_rest = motion.steps_at_rest;
    if (!go_on || context_->lost()) break;
  }
  if (motion.steps == 0 && !context_->lost() && tools_.undo_hold()) device_->set_held(tools_);
  return motion;
}

StepConstants DeviceSolver::constants_of(const StepPlan& plan) const {
  const RestThresholds asked{plan.speed_at_rest, plan.acceleration_at_rest};
  const RestThresholds rest = joints().empty() ? rest_thresholds(asked, progress_.largest_displacement)
                                               : rest_thresholds(asked, progress_.largest_displacement, plan.omega_max);
  return {.dt = plan.dt,
          .damping_factor = plan.damping_factor,
          .last_dt = progress_.last_dt,
          .tools_at_once = plan.stop_at_rest,
          .largest_acceleration = plan.largest_acceleration,
          .runaway_speed = plan.runaway_speed,
          .speed_at_rest = rest.speed,
          .acceleration_at_rest = rest.acceleration};
}

/// After run(count): which of its steps count, and takes over what they did, but to tools.
DeviceSolver::BatchEnd DeviceSolver::end_batch(const StepPlan& plan, int count, Motion& motion) {
  BatchReport report = device_->report();
  BatchEnd end{.first = report};
  // A volume that cannot be restored comes before what runs away with it in the same step.
  end.loses = report.lost_step > 0 && (report.runaway_step == 0 || report.lost_step <= report.runaway_step);
  end.failed_at = end.loses ? report.lost_step : report.runaway_step;
  end.good = end.failed_at > 0 ? end.failed_at - 1 : count;
  const int until_rest = std::max(plan.rest_steps - motion.steps_at_rest, 1);
  const int quiet = report.first_unquiet > 0 ? std::min(report.first_unquiet - 1, end.good) : end.good;
  end.rests = plan.stop_at_rest && quiet >= until_rest;
  if (end.rests) end.good = until_rest;
  if (end.good < count) {
    device_->run(end.good);
    if (end.good > 0) report = device_->report();
  }
  if (end.good == 0) return end;
  take_over(plan, end.good, report, motion);
  motion.steps += end.good;
  motion.steps_at_rest = report.last_unquiet > 0 ? end.good - report.last_unquiet : motion.steps_at_rest + end.good;
  progress_.steps_at_rest = motion.steps_at_rest;
  return end;
}

/// Of steps that count.
void DeviceSolver::take_over(const StepPlan& plan, int steps, const BatchReport& report, Motion& motion) {
  joint_sums_.assign(scene().tools().size(), {});
  if (!joints().empty()) {
    joints().take(told_joints(device_->read_joints()), joint_sums_);
    joints().accept();
  }
  motion.force_clamped = motion.force_clamped || report.cut;
  motion.max_speed = report.max_speed;
  motion.max_acceleration = report.max_acceleration;
  motion.max_force = report.max_force;
  progress_.largest_displacement = report.max_displacement;
  for (int k = 0; k < steps; ++k) progress_.time += plan.dt;
  progress_.last_dt = plan.dt;
}

/// False where the motion ends with this batch: a failure, or rest.
bool DeviceSolver::run_batch(const StepPlan& plan, int count, Motion& motion) {
  instants_.assign(1, progress_.time);
  for (int k = 0; k < count; ++k) instants_.push_back(instants_.back() + plan.dt);
  if (!tools_.empty()) count = tools_.begin_batch(count, plan.dt);
  if (count == 0) {
    motion.not_finite = pose_not_finite;
    return false;
  }
  device_->begin_batch(constants_of(plan), instants_, tools_);
  device_->run(count);
  const BatchEnd end = end_batch(plan, count, motion);
  if (end.good > 0 && !tools_.empty()) {
    tools_.accept(end.good, plan.dt, device_->tool_sums(), joints().pulls(), joint_sums_);
  }
  if (end.rests || end.failed_at == 0) return !end.rests;
  if (end.loses) {
    motion.lost_volume = end.first.lost_volume;
    return false;
  }
  // The forces that the step after the last good one began with, which are those of the state that is kept.
  const BatchReport failed = device_->try_step(end.good + 1);
  motion.max_acceleration = failed.max_acceleration;
  motion.max_force = failed.max_force;
  motion.bad_particle = end.first.particle;
  return false;
}

SolverBackend::Motion DeviceSolver::run_on_host(const StepPlan& plan) {
  host_->tools.begin_call(scene(), plan.steps, plan.stop_at_rest);
  Motion motion;
  motion.steps_at_rest = progress_.steps_at_rest;
  bool goes_on = true;
  while (goes_on && motion.steps < plan.steps && !context_->lost()) {
    const int steps = steps_out_of_reach(plan, plan.steps - motion.steps);
    goes_on = (steps == 0 || pass_on_host(plan, steps, motion)) &&
              (motion.steps == plan.steps || StepOrder::step(*this, plan, motion));
  }
  return motion;
}

/// 0: something may touch the body in the next few.
int DeviceSolver::steps_out_of_reach(const StepPlan& plan, int remaining) {
  if (progress_.fastest < 0.0) return 0;
  const int most = plan.stop_at_rest ? std::min(remaining, plan.rest_steps) : remaining;
  for (const int batch : batches) {
    const int steps = std::min(batch, most);
    const double going = faster * progress_.fastest * plan.dt, more = steps * going;
    if (host_->touching.may_act(going, host_->step.gone() + more)) continue;
    host_->step.look(*device_);
    const auto any_in = [&](const Region& region) { return host_->step.any_in(region, more); };
    if (!host_->tools.may_touch(steps, plan.dt, host_->step.wide(more), any_in)) return steps;
  }
  return 0;
}

/// Joints look at where tools are.
void DeviceSolver::begin_tools_on_host(int steps, double dt) {
  if (joints().empty() || tools_.empty()) return;
  for (std::size_t row = 0; row < host_->tools.count(); ++row) {
    tools_.set_motion(row, host_->tools.moved(row).motion, host_->tools.is_let_go(row));
  }
  tools_.begin_batch(steps, dt);
}

/// False where the motion ends with these steps: a failure, or rest.
bool DeviceSolver::pass_on_host(const StepPlan& plan, int steps, Motion& motion) {
  instants_.assign(1, progress_.time);
  for (int k = 0; k < steps; ++k) instants_.push_back(instants_.back() + plan.dt);
  begin_tools_on_host(steps, plan.dt);
  StepConstants constants = constants_of(plan);
  const double fastest = faster * progress_.fastest;
  constants.runaway_speed = std::min(fastest, plan.runaway_speed);
  device_->begin_batch(constants, instants_, tools_);
  device_->run(steps);
  const BatchEnd end = end_batch(plan, steps, motion);
  if (end.good == 0) return true;
  host_->step.accept(end.good * fastest * plan.dt, end.good);
  host_->tools.pass(end.good, plan.dt, joints().pulls(), joint_sums_);
  return !end.rests;
}

// Stages of StepOrder: the device executes what comes before touch() as one.

void DeviceSolver::begin(const StepPlan& plan) {
  instants_.assign({progress_.time, progress_.time + plan.dt});
  begin_tools_on_host(1, plan.dt);
  device_->begin_batch(constants_of(plan), instants_, tools_);
}

void DeviceSolver::predict(const StepPlan& plan) {
  host_->step.begin(*device_, plan.dt, progress_.largest_displacement);
}

int DeviceSolver::touch(const StepPlan& plan) {
  host_->touched.begin(host_->step, plan.dt, progress_.last_dt);
  host_->tools.act(host_->touched);
  const int lost = host_->touching.act(host_->touched);
  host_->tools.feel(host_->touched);
  host_->longest_way = host_->touched.going();
  host_->touched.end();
  return lost;
}

Index DeviceSolver::move(const StepPlan& /*plan*/, Motion& motion) {
  host_->step.close();
  host_->report = device_->report();
  motion.max_acceleration = host_->report.max_acceleration;
  motion.max_force = host_->report.max_force;
  return host_->report.runaway_step > 0 ? host_->report.particle : -1;
}

/// Joints are the device's: accept() takes them over.
const char* DeviceSolver::settle() {
  const char* const fluid = host_->touching.first_not_finite();
  return *fluid != '\0' ? fluid : host_->tools.first_not_finite();
}

void DeviceSolver::drop_step() {
  host_->step.drop();
  host_->tools.drop();
  device_->go_back();
}

void DeviceSolver::accept(const StepPlan& plan, Motion& motion) {
  const BatchReport& report = host_->report;
  host_->step.accept(host_->longest_way);
  take_over(plan, 1, report, motion);
  progress_.fastest = std::max(host_->longest_way / plan.dt, report.max_speed) + plan.dt * report.max_acceleration;
  if (!joints().empty()) host_->tools.pull(joints().pulls());
  host_->tools.accept();
}

/// Of the numbers that the device compares.
RestThresholds DeviceSolver::rest_now(const StepPlan& plan, const Motion& /*motion*/) const {
  const StepConstants constants = constants_of(plan);
  return {to_float(constants.speed_at_rest), to_float(constants.acceleration_at_rest)};
}

}  // namespace phymul::gl
