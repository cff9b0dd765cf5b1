// SPDX-License-Identifier: MIT
#include "device_solver.h"

#include <phymul/error.h>

#include <algorithm>
#include <utility>

#include "body_kind.h"
#include "device/float_range.h"
#include "device/float_tables.h"
#include "gl/fragment/fragment_device.h"
#include "interaction/tool_shape.h"
#include "model/outer_faces.h"

namespace phymul::gl {
namespace {

/// Another context sees what was drawn here only once it is done. After a step, whose report was waited for, it is.
ParticleBuffer finished(const Texture& texture) {
  glFinish();
  return {.texture = texture.id(), .width = texture.shape().width, .height = texture.shape().height, .position = {}};
}

}  // namespace

DeviceSolver::DeviceSolver(GlBackend backend, std::shared_ptr<const TopologyTextures> shared, const Scene& scene_in,
                           const SolverOptions& options_in)
    : SolverBackend(name_of(backend), std::move(shared), scene_in, options_in),
      backend_(backend),
      gl_(options_in.gl),
      layout_(choose_layout(gl_.layout, topology())),
      context_(Context::open(gl_, backend)),
      kept_(rest_state(model())) {
  if (const char* const cause = beyond_devices()) throw Error(ErrorCode::not_supported, cause);
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

/// Not in order on a device: tools that do more than press, surfaces under tools, threads. Not by fragments, 83 to 109
/// draws a step: contacts. And not tabled there: which volumes an edit of the body has opened, and faces of cuts that
/// touch.
bool DeviceSolver::acts_on_host() const {
  return holds_what_is_pushed() || (scene().contacts() && (backend_ == GlBackend::fragment || has_cuts(model()))) ||
         scene().any_volume_open() || !scene().threads().empty() ||
         std::ranges::any_of(scene().tools(), [](const SceneTool& own) {
           return own.tool.contact == ToolContact::surface || !beyond_pressing(own.tool).empty();
         });
}

/// Nor does a tool feel there what contacts and volumes do to what it holds, or is about to.
bool DeviceSolver::holds_what_is_pushed() const {
  if (!scene().contacts() && scene().volume_constraints().empty()) return false;
  for (std::size_t row = 0; row < scene().tools().size(); ++row) {
    const SceneTool& own = scene().tools()[row];
    const ToolReport& now = do_tool_report(row);
    if (now.held > 0 || (own.grasping && own.grasps != now.grasps)) return true;
  }
  return false;
}

/// After tools_, from which tools come here as they are.
void DeviceSolver::follow_on_host() {
  if (!acts_on_host()) {
    host_.reset();
    return;
  }
  const bool moves_here = host_ == nullptr;
  if (moves_here) host_ = std::make_unique<OnHost>(model());
  host_->tools.follow(scene());
  for (std::size_t row = 0; moves_here && row < host_->tools.count(); ++row) {
    host_->tools.set_moved(row, tools_.moved(row));
  }
  if (moves_here) host_->tools.set_was_reset(tools_.was_reset());
  host_->touching.follow(scene(), host_->tools.surface());
  host_->touched.prepare(topology().mass, frame().fixed, topology().dimension == 2);
}

void DeviceSolver::build() {
  FloatTables tables = pack_floats(topology(), layout_);
  loads_version_ = scene().version();
  tools_.follow(scene());
  holds_pushed_ = holds_what_is_pushed();
  const ContextInfo& info = context_->info();
  require_turns(info, tables.turns);
  const ShaderLibrary library(gl_.shader_folder, info.es, !info.es || info.at_least(3, 2));
  std::vector<Index> domains;
  if (backend_ == GlBackend::compute) {
    context_->run([&] {
      device_ = make_compute_device(std::move(tables), topology(), scene(), tools_, acts_on_host(), library, domains);
    });
  } else {
    context_->run(
        [&] { device_ = std::make_unique<FragmentDevice>(tables, scene(), tools_, acts_on_host(), library); });
    domains = std::move(tables.domains.source);
  }
  if (!topology().dissipation.empty()) dissipation_.emplace(topology(), std::move(domains));
  dissipation_dt_ = 0.0;
  joints_told_ = false;
  follow_on_host();
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

/// All tables are made and sent anew.
void DeviceSolver::do_body_changed(std::span<const Index> /*domains*/) {
  Snapshot now;
  do_snapshot(now);
  now.state = without_removed(std::move(now.state));
  for (std::size_t i = 0; i < now.displacement.size(); ++i) {
    if (topology().mass[i] == 0.0) now.displacement[i].setZero();
  }
  drop();
  if (host_) host_->step.follow_body(model());
  build();
  do_restore(now);
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
    const State newest = kept_;
    do_reset(newest);
    joints().reset(newest);
  } catch (...) {
    drop();
    progress_.time = kept_.time;
  }
}

template <class Function>
auto DeviceSolver::on_device(Function&& function) const {
  if (!device_)
    throw Error(ErrorCode::device, "the device of this solver is lost, and no other could be had; see Solver::reset");
  struct LostCheck {
    Context& context;
    void operator()() const {
      if (context.lost()) throw Error(ErrorCode::device, "the device of this solver was lost; see Solver::reset");
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
  context_->run([&] {
    tools_.reset(scene(), state);
    device_->drop_copies();
    device_->write(topology().rest, state);
    device_->set_held(tools_);
    joints_told_ = false;
  });
  if (host_) {
    host_->tools.reset(scene(), state);
    host_->touching.forget();
    host_->step.forget();
  }
  kept_ = state;
  progress_ = {.time = state.time, .last_dt = 0.0, .steps_at_rest = 0, .largest_displacement = largest};
}

/// Takes the scene's loads and tools to the device, where they have changed; all of it or nothing.
void DeviceSolver::follow() {
  const bool holds = holds_what_is_pushed();
  if (loads_version_ == scene().version() && holds_pushed_ == holds) return;
  FloatTools tools = tools_;
  tools.follow(scene());
  const bool on_host = acts_on_host();
  for (std::size_t row = 0; host_ && row < scene().tools().size(); ++row) {
    if (const MovedTool* const moved = host_->tools.find(scene().tools()[row].id)) tools.set_moved(row, *moved);
  }
  context_->run([&] { device_->set_scene(scene(), tools, on_host); });
  tools_ = std::move(tools);
  follow_on_host();
  joints_told_ = false;
  loads_version_ = scene().version();
  holds_pushed_ = holds;
  seconds_a_step_ = 0.0;
}

SolverBackend::Motion DeviceSolver::lost_motion() {
  return {.lost = true};
}

SolverBackend::Motion DeviceSolver::do_step(const StepPlan& plan) {
  try {
    if (device_ && !context_->lost()) {
      follow();
      const Motion motion = context_->run([&] { return run_batches(plan); });
      context_->throw_debug_errors();
      if (!context_->lost()) return motion;
    }
  } catch (const Unreachable&) {  // the device and its state stay, for when the host makes its context current again
    return lost_motion();
  } catch (const Error&) {
    // What has changed does not fit the device.
    if (!context_->lost() && (loads_version_ != scene().version() || holds_pushed_ != holds_what_is_pushed())) throw;
  } catch (...) {  // a device that refuses what it did before is lost to us
  }
  recover();
  return lost_motion();
}

void DeviceSolver::do_read(State& state) const {
  if (device_ && !context_->lost()) {
    State now;
    context_->run([&] { device_->read(topology().rest, now); });
    now.time = progress_.time;
    read_tools(now);
    joints().read(now);
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
  if (dissipation_) put_strains(strains(), snapshot);
  snapshot.last_dt = progress_.last_dt;
  snapshot.steps_at_rest = progress_.steps_at_rest;
}

void DeviceSolver::do_restore(const Snapshot& snapshot) {
  if (!dissipation_ || snapshot.parts.size() != 1 || !has_strains(snapshot)) refuse_parts(snapshot);
  const StrainMemory memory = strains_of(snapshot, topology());
  const double largest = require_state_in_range(topology().rest, snapshot.state, snapshot.displacement);
  do_reset(snapshot.state);
  progress_.largest_displacement = largest;
  if (!snapshot.displacement.empty()) {
    State displaced = snapshot.state;
    displaced.position = snapshot.displacement;
    const VecList origin(displaced.position.size(), Vec3::Zero());
    on_device([&] { device_->write(origin, displaced); });
  }
  if (!memory.empty()) on_device([&] { device_->write_strains(dissipation_->rows(memory)); });
  progress_.last_dt = snapshot.last_dt;
  progress_.steps_at_rest = snapshot.steps_at_rest;
}

/// Empty also where the device is lost, and its strains with it.
StrainMemory DeviceSolver::strains() const {
  if (!device_ || context_->lost()) return {};
  const std::vector<Float4> rows = on_device([&] { return device_->read_strains(); });
  return rows.empty() ? StrainMemory() : dissipation_->memory(rows);
}

Energy DeviceSolver::do_energy() const {
  const State state = read();
  DissipationNow now;
  if (dissipation_) now = dissipation_at(elastic(), state.position, strains(), progress_.last_dt);
  Energy energy = energy_of(state, progress_.last_dt, now.force);
  energy.elastic += now.energy;
  return energy;
}

void DeviceSolver::do_profile() const {
  if (!device_ || !device_->timer() || context_->lost()) return;
  context_->run([this] { device_->timer()->finish(); });
}

void DeviceSolver::do_request_read() {
  State header;
  header.time = progress_.time;
  on_device([&] {
    read_tools(header);
    joints().read(header);
    device_->request_copy(header);
  });
}

bool DeviceSolver::do_collect(State& state) {
  if (!on_device([&] { return device_->collect_copy(topology().rest, state); })) return false;
  if (state.time >= kept_.time) kept_ = state;
  return true;
}

ParticleBuffer DeviceSolver::do_position_buffer() const {
  if (!device_) return {};
  return on_device([&] { return finished(device_->displacements()); });
}

std::unique_ptr<Solver> make_device_solver(GlBackend backend, std::shared_ptr<const TopologyTextures> topology,
                                           const Scene& scene, const SolverOptions& options) {
  return std::make_unique<DeviceSolver>(backend, std::move(topology), scene, options);
}

}  // namespace phymul::gl
