// SPDX-License-Identifier: MIT
#include "gl/device_solver.h"

#include <phymul/error.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "base_layout.h"
#include "gl/compute_device.h"
#include "gl/fragment_device.h"
#include "gl/options.h"
#include "gl/step_traffic.h"
#include "slice_tables.h"

namespace phymul::gl {
namespace {

/// A batch of steps that takes longer keeps the device from drawing, and a window system may take it for hung.
constexpr double seconds_a_batch = 0.05;
constexpr int first_batch = 8;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Another context sees what was drawn here only once it is done. After a step, whose report was waited for, it is.
ParticleBuffer finished(const Texture& texture) {
  glFinish();
  return {.texture = texture.id(), .width = texture.shape().width, .height = texture.shape().height, .position = {}};
}

/// Else forces would be missing, and nobody the wiser.
void require_turns(const ContextInfo& info, LoopTurns turns, bool recomputes) {
  const std::int64_t all = recomputes ? turns.gathered * (1 + turns.own) : turns.own + turns.gathered;
  if (all <= info.loop_turns) return;
  throw Error("expected at most " + std::to_string(info.loop_turns) +
              " turns of the loops of a shader, which is where " + info.renderer + " breaks off, got up to " +
              std::to_string(all) + " for a particle of this body; use fewer bases" +
              (recomputes ? ", the form that stores," : "") + " or another backend");
}

}  // namespace

DeviceSolver::DeviceSolver(GlBackend backend, std::shared_ptr<const TopologyTextures> shared, const Scene& scene_in,
                           const SolverOptions& options_in)
    : Solver(name_of(backend), std::move(shared), scene_in, options_in),
      backend_(backend),
      gl_(with_environment(options_in.gl)),
      layout_(choose_layout(gl_.layout, topology())),
      context_(Context::open(gl_, backend)),
      kept_(rest_state(model())) {
  instants_.reserve(Device::most_steps + 1);
  try {
    build();
    reset();
  } catch (...) {
    drop();
    throw;
  }
}

DeviceSolver::~DeviceSolver() {
  drop();
}

void DeviceSolver::build() {
  FloatTables tables = pack_floats(topology(), layout_);
  loads_version_ = scene().version();
  tools_.follow(scene());
  const ContextInfo& info = context_->info();
  const ShaderLibrary library(gl_.shader_folder, info.es, !info.es || info.at_least(3, 2));
  if (backend_ == GlBackend::compute) {
    const SliceTables slices = pack_slices(std::move(tables), topology());
    const ComputeForm form = choose_form(gl_.compute, slices, info.software);
    const bool thesis = topology().options.reaction != Reaction::averaged;  // whose forces every neighbour recomputes
    require_turns(info, slices.rows.turns, thesis && form == ComputeForm::recompute);
    const bool counted = form != ComputeForm::recompute;
    bytes_a_step_ = counted ? gl::bytes_a_step(slices) : std::numeric_limits<double>::quiet_NaN();
    context_->run([&] { device_ = std::make_unique<ComputeDevice>(slices, scene(), tools_, library, form); });
  } else {
    require_turns(info, tables.turns, false);
    bytes_a_step_ = gl::bytes_a_step(tables);
    context_->run(
        [&] { device_ = std::make_unique<FragmentDevice>(tables, scene(), tools_, library, gl_.passes == 4); });
  }
  if (profiling()) context_->run([&] { device_->time_passes(context_->info(), *profiling()); });
  context_->throw_debug_errors();
}

/// Deleting is harmless in a lost context that can still be made current. Where it cannot, another context may be
/// current, whose objects must not be touched: ours are then left behind with the context they went with.
void DeviceSolver::drop() noexcept {
  if (!device_) return;
  try {
    context_->run([this] { device_.reset(); });
  } catch (...) {
    static_cast<void>(device_.release());
  }
}

void DeviceSolver::rebuild() {
  drop();
  context_ = Context::open(gl_, backend_);
  build();
}

/// Another context, and the newest state the host has.
void DeviceSolver::recover() noexcept {
  try {
    rebuild();
    do_reset(State(kept_));
  } catch (...) {
    drop();
    progress_.time = kept_.time;
  }
}

template <class Function>
auto DeviceSolver::on_device(Function&& function) const {
  if (!device_) throw Error("the device of this solver is lost, and no other could be had; see Solver::reset");
  struct LostCheck {
    Context& context;
    void operator()() const {
      if (context.lost()) throw Error("the device of this solver was lost; see Solver::reset");
    }
  } check{*context_};
  if constexpr (std::is_void_v<std::invoke_result_t<Function&>>) {
    context_->run(std::forward<Function>(function));
    check();
  } else {
    auto result = context_->run(std::forward<Function>(function));
    check();
    return result;
  }
}

void DeviceSolver::do_reset(const State& state) {
  const double largest = require_state_in_range(topology().rest, state);
  if (!device_ || context_->lost()) rebuild();
  follow();
  tools_.reset(scene(), state);
  context_->run([&] {
    device_->drop_copies();
    device_->write(topology().rest, state);
    device_->set_held(tools_);
  });
  kept_ = state;
  late_.reset();
  untold_.reset();
  progress_ = {.time = state.time, .last_dt = 0.0, .steps_at_rest = 0, .largest_displacement = largest};
}

void DeviceSolver::do_scene_changed() {
  try {
    settle();
  } catch (...) {  // do_step() finds out and says so
  }
  progress_.steps_at_rest = 0;
}

/// Takes the scene's loads and tools to the device, where they have changed.
void DeviceSolver::follow() {
  if (loads_version_ == scene().version()) return;
  tools_.follow(scene());
  context_->run([this] { device_->set_scene(scene(), tools_); });
  loads_version_ = scene().version();
}

Solver::Motion DeviceSolver::do_step(const StepPlan& plan) {
  try {
    if (device_ && !context_->lost()) {
      settle();  // under the scene it was done in
      follow();
      // Where the caller asked for progress a call is many plans, each of which needs its own report.
      const bool late = gl_.late_report && !options().progress;
      const Motion motion = context_->run([&] { return late ? run_late(plan) : run_batches(plan); });
      context_->throw_debug_errors();
      if (!context_->lost()) return motion;
    }
  } catch (const Unreachable&) {  // the device and its state stay, for when the host makes its context current again
    Motion motion;
    motion.lost = true;
    return motion;
  } catch (...) {  // a device that refuses what it did before is lost to us
  }
  recover();
  Motion motion;
  motion.lost = true;
  return motion;
}

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

Solver::Motion DeviceSolver::run_batches(const StepPlan& plan) {
  begin_tools(plan);
  const PassTimer::Current timing(device_->timer());
  Motion motion;
  motion.steps_at_rest = progress_.steps_at_rest;
  while (motion.steps < plan.steps) {
    const int count = batch_size(plan, plan.steps - motion.steps);
    const auto start = std::chrono::steady_clock::now();
    queue_batch(plan, count);
    const bool go_on = settle_batch(plan, count, motion);
    seconds_a_step_ = seconds_since(start) / count;
    progress_.steps_at_rest = motion.steps_at_rest;
    if (!go_on || context_->lost()) break;
  }
  return motion;
}

/// The report of the call before, while the last batch of this one is on its way. run_to_rest() waits for every batch.
Solver::Motion DeviceSolver::run_late(const StepPlan& plan) {
  const Motion before = std::exchange(untold_, std::nullopt).value_or(Motion{});
  if (before.bad_particle >= 0) return before;
  if (plan.stop_at_rest) return run_batches(plan);
  begin_tools(plan);
  const PassTimer::Current timing(device_->timer());
  Motion motion;
  motion.steps_at_rest = progress_.steps_at_rest;
  for (int left = plan.steps; left > 0;) {
    const int count = batch_size(plan, left);
    const auto start = std::chrono::steady_clock::now();
    queue_batch(plan, count);
    left -= count;
    if (left == 0) {
      late_ = Late{plan, count, motion};
      break;
    }
    if (!settle_batch(plan, count, motion)) return motion;
    seconds_a_step_ = seconds_since(start) / count;
    progress_.steps_at_rest = motion.steps_at_rest;
  }
  return before;
}

/// Waits for the batch whose report is on its way. Whatever it says is told by the next step().
void DeviceSolver::settle() const {
  if (!late_) return;
  Late late = *late_;
  on_device([&] {
    const PassTimer::Current timing(device_->timer());
    settle_batch(late.plan, late.count, late.motion);
  });
  late_.reset();
  progress_.steps_at_rest = late.motion.steps_at_rest;
  untold_ = late.motion;
}

void DeviceSolver::queue_batch(const StepPlan& plan, int count) {
  instants_.assign(1, progress_.time);
  for (int k = 0; k < count; ++k) instants_.push_back(instants_.back() + plan.dt);
  const RestThresholds rest =
      rest_thresholds({plan.speed_at_rest, plan.acceleration_at_rest}, progress_.largest_displacement);
  if (!tools_.empty()) tools_.begin_batch(count, plan.dt);
  device_->begin_batch({.dt = plan.dt,
                        .damping_factor = plan.damping_factor,
                        .largest_acceleration = plan.largest_acceleration,
                        .runaway_speed = plan.runaway_speed,
                        .speed_at_rest = rest.speed,
                        .acceleration_at_rest = rest.acceleration},
                       instants_, tools_);
  device_->run(count);
  device_->request_report();
}

/// False where the motion ends with this batch: a failure, or rest.
bool DeviceSolver::settle_batch(const StepPlan& plan, int count, Motion& motion) const {
  BatchReport report = device_->take_report();
  const int failed_at = report.runaway_step;
  const Index culprit = report.particle;
  int good = failed_at > 0 ? failed_at - 1 : count;

  const int until_rest = std::max(plan.rest_steps - motion.steps_at_rest, 1);
  const int quiet = report.first_unquiet > 0 ? std::min(report.first_unquiet - 1, good) : good;
  const bool rests = plan.stop_at_rest && quiet >= until_rest;
  if (rests) good = until_rest;
  if (good < count) {
    device_->run(good);
    if (good > 0) report = device_->report();
  }
  if (good > 0) {
    motion.cut = motion.cut || report.cut;
    motion.steps_at_rest = report.last_unquiet > 0 ? good - report.last_unquiet : motion.steps_at_rest + good;
    motion.max_speed = report.max_speed;
    motion.max_acceleration = report.max_acceleration;
    motion.max_force = report.max_force;
    progress_.largest_displacement = report.max_displacement;
    if (!tools_.empty()) tools_.accept(good, plan.dt, device_->tool_sums());
  }
  motion.steps += good;
  for (int k = 0; k < good; ++k) progress_.time += plan.dt;
  if (good > 0) progress_.last_dt = plan.dt;
  if (rests || failed_at == 0) return !rests;
  // The forces that the step after the last good one began with, which are those of the state that is kept.
  const BatchReport failed = device_->try_step(good + 1);
  motion.max_acceleration = failed.max_acceleration;
  motion.max_force = failed.max_force;
  motion.bad_particle = culprit;
  return false;
}

void DeviceSolver::do_read(State& state) const {
  try {
    settle();
  } catch (const Error&) {
    if (device_ && !context_->lost()) throw;
  }
  if (device_ && !context_->lost()) {
    State now;
    context_->run([&] { device_->read(topology().rest, now); });
    now.time = progress_.time;
    tools_.read(now);
    if (!context_->lost()) kept_ = std::move(now);
  }
  state = kept_;
}

/// The device's displacements come and go as they are where rest places are taken to be 0.
void DeviceSolver::do_snapshot(Snapshot& snapshot) const {
  do_read(snapshot.state);
  State displaced;
  const VecList origin(snapshot.state.position.size(), Vec3::Zero());
  on_device([&] { device_->read(origin, displaced); });
  snapshot.displacement = std::move(displaced.position);
  snapshot.last_dt = progress_.last_dt;
  snapshot.steps_at_rest = progress_.steps_at_rest;
}

void DeviceSolver::do_restore(const Snapshot& snapshot) {
  refuse_parts(snapshot);
  do_reset(snapshot.state);
  if (!snapshot.displacement.empty()) {
    State displaced = snapshot.state;
    displaced.position = snapshot.displacement;
    const VecList origin(displaced.position.size(), Vec3::Zero());
    on_device([&] { device_->write(origin, displaced); });
  }
  progress_.last_dt = snapshot.last_dt;
  progress_.steps_at_rest = snapshot.steps_at_rest;
}

/// Not counted where there are tools: it depends on how much they touch.
double DeviceSolver::do_bytes_a_step() const {
  return tools_.empty() ? bytes_a_step_ : std::numeric_limits<double>::quiet_NaN();
}

Energy DeviceSolver::do_energy() const {
  settle();
  return on_device([&] { return device_->energy(scene(), progress_.time, progress_.last_dt); });
}

void DeviceSolver::do_profile() const {
  if (!device_ || !device_->timer() || context_->lost()) return;
  context_->run([this] { device_->timer()->finish(); });
}

Momentum DeviceSolver::do_momentum(const Vec3& about) const {
  settle();
  return on_device([&] { return device_->momentum(topology().rest, about); });
}

void DeviceSolver::do_request_read() {
  settle();
  State header;
  header.time = progress_.time;
  tools_.read(header);
  on_device([&] { device_->request_copy(header); });
}

bool DeviceSolver::do_collect(State& state) {
  if (!on_device([&] { return device_->collect_copy(topology().rest, state); })) return false;
  if (state.time >= kept_.time) kept_ = state;
  return true;
}

ParticleBuffer DeviceSolver::do_position_buffer() const {
  if (!device_) return {};
  settle();
  return on_device([&] { return finished(device_->displacements()); });
}

ParticleBuffer DeviceSolver::do_attractor_buffer() const {
  settle();
  return on_device([&] { return finished(device_->attractors()); });
}

std::unique_ptr<Solver> make_device_solver(GlBackend backend, std::shared_ptr<const TopologyTextures> topology,
                                           const Scene& scene, const SolverOptions& options) {
  return std::make_unique<DeviceSolver>(backend, std::move(topology), scene, options);
}

}  // namespace phymul::gl
