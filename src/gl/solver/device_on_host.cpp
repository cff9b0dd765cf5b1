// SPDX-License-Identifier: MIT
//
// The steps of DeviceSolver where something acts on the host: one by one while it may touch the body, else in batches,
// in which nothing is read. That nothing was in reach rests on a bound of the body's motion, which a batch reports if a
// particle breaks it: its steps before that one count.
#include <algorithm>
#include <array>

#include "device_solver.h"
#include "solver/step_order.h"

namespace phymul::gl {
namespace {

/// Times what particles do now: room for what they may do before the next look.
constexpr double faster = 3.0;

constexpr std::array batches{64, 16, 4};  // steps

}  // namespace

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
