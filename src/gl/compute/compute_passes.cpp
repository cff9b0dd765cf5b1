// SPDX-License-Identifier: MIT
#include "compute_passes.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int lanes = 64;  // of a group where groups are many

/// Beyond, one group of invocations takes longer than dispatches of many, which cost some 5 to 8 us a step to launch:
/// reckoned from a GPU whose multiprocessor evaluates a base in each of 128 lanes in 50 cycles. A domain counts for
/// the seven directions it is evaluated in.
constexpr double workgroup_bases = 16384.0;

constexpr std::int64_t turns_a_tool = 66;  // of loops, for one particle: contact_tool.glsl looks along its way in 64

const ShaderFiles common{"dialect/dialect_compute.glsl", "step/tables.glsl", "dialect/kernel_language.glsl"};

void append(ShaderRequest& request, const ShaderFiles& files) {
  for (const std::string& file : files) {
    if (std::ranges::find(request.files, file) == request.files.end()) request.files.push_back(file);
  }
}

void define(ShaderRequest& request, const char* name, bool wanted = true) {
  if (wanted) request.defines.emplace_back(name, 1);
}

}  // namespace

ComputeForm choose_form(GlCompute wish, const SliceTables& slices, bool software) {
  switch (wish) {
    case GlCompute::store:
      return ComputeForm::store;
    case GlCompute::workgroup:
      return ComputeForm::workgroup;
    case GlCompute::automatic:
      break;
  }
  const FloatTables& rows = slices.rows;
  const double bases = static_cast<double>(rows.base_count) + 4.0 * static_cast<double>(rows.height.size());
  const double others = static_cast<double>(rows.volume_count) + 7.0 * static_cast<double>(rows.domains.count()) +
                        static_cast<double>(rows.domains.link.size()) + static_cast<double>(rows.spring.size()) +
                        static_cast<double>(rows.particle_count);
  return !software && bases + others <= workgroup_bases ? ComputeForm::workgroup : ComputeForm::store;
}

ComputePasses::ComputePasses(const ComputeTables& tables, const ShaderLibrary& library, ComputeForm form,
                             const ComputeLimits& limits)
    : tables_(&tables), library_(&library), form_(form), limits_(limits) {}

/// The passes before the step that are asked for, and what they need.
ShaderRequest ComputePasses::evaluating(const TermRows& rows) const {
  const BodyKind& kind = tables_->kind();
  ShaderRequest request{.files = common, .defines = {}};
  tables_->define(request);
  define(request, "AVERAGED", kind.base_terms && !kind.conservative());
  define(request, "ATTRACTOR_ROWS", rows.attractors);
  define(request, "BASE_ROWS", rows.bases);
  define(request, "VOLUME_ROWS", rows.volumes);
  define(request, "DOMAIN_ROWS", rows.domains);
  if (rows.attractors || rows.bases) append(request, base_kernel());
  if (rows.attractors) append(request, attractor_files(kind));
  if (kind.attractors) append(request, {"step/force_of.glsl"});
  if (rows.bases) append(request, {"step/bases_pass.glsl"});
  if (rows.volumes) append(request, joined({volume_kernel(), {"step/volumes_pass.glsl"}}));
  if (rows.domains) append(request, joined({energy_kernel(kind), {"step/domains_pass.glsl"}}));
  return request;
}

Kernel ComputePasses::placed(ShaderRequest request, int group, const ComputeState& state) const {
  Kernel kernel(*library_, std::move(request), group, limits_);
  tables_->place(kernel);
  state.place(kernel);
  const BodyKind& kind = tables_->kind();
  kernel.set("base_rows_count", kind.bases);
  kernel.set("volume_count", kind.volumes);
  kernel.set("domain_count", kind.domains);
  return kernel;
}

ComputePasses::TermRows ComputePasses::all_terms() const {
  const BodyKind& kind = tables_->kind();
  return {.attractors = kind.attractors,
          .bases = kind.base_terms,
          .volumes = kind.volumes > 0,
          .domains = kind.domains > 0};
}

void ComputePasses::add_terms(const TermRows& rows, const ComputeState& state) {
  if (!rows.any()) return;
  const BodyKind& kind = tables_->kind();
  ShaderRequest request = evaluating(rows);
  append(request, {"step/store_terms.glsl", "step/terms_kernel.glsl"});
  Terms terms;
  terms.kernel = placed(std::move(request), lanes, state);
  if (rows.attractors) terms.attractor_groups = terms.kernel.groups_for(kind.particles);
  if (rows.bases) terms.base_groups = terms.kernel.groups_for(kind.bases);
  if (rows.volumes) terms.volume_groups = terms.kernel.groups_for(kind.volumes);
  if (rows.domains) terms.domain_groups = terms.kernel.groups_for(kind.domains);
  terms.kernel.set("attractor_groups", terms.attractor_groups);
  terms.kernel.set("base_groups", terms.base_groups);
  terms.kernel.set("volume_groups", terms.volume_groups);
  terms_.push_back(std::move(terms));
}

/// With the averaged reaction bases read forces that must be there.
void ComputePasses::compile_terms(const ComputeState& state) {
  TermRows rows = all_terms();
  const bool apart = rows.attractors && rows.bases;
  if (apart) rows.bases = false;
  terms_.clear();  // of an attempt that failed half-way
  add_terms(rows, state);
  if (apart) add_terms({.bases = true}, state);
  terms_compiled_ = true;
}

void ComputePasses::evaluate(const ComputeState& state) {
  if (!terms_compiled_) compile_terms(state);
  for (Terms& terms : terms_) {
    terms.kernel.set("pair", state.current());
    terms.kernel.dispatch(terms.groups());
  }
}

ShaderRequest ComputePasses::gathering(const LoadKind& loads, bool with_passes) const {
  const BodyKind& kind = tables_->kind();
  ShaderRequest request = evaluating(with_passes ? all_terms() : TermRows{});
  define_gathering(kind, loads, request);
  append(request, {"kernels/spring.glsl", "kernels/integrate.glsl", "step/terms_of.glsl", "step/net_force.glsl"});
  return request;
}

int ComputePasses::workgroup() const {
  const BodyKind& kind = tables_->kind();
  const int rows = std::max({kind.particles, kind.base_terms ? kind.bases : 0, kind.volumes, kind.domains});
  const int most = std::min(limits_.invocations, 1024);
  return std::min((rows + 31) / 32 * 32, most / 32 * 32);
}

/// Turns of the loops of a step of one group.
std::int64_t ComputePasses::turns_a_step(std::int64_t tools, const ComputeVolumes* volumes) const {
  const BodyKind& kind = tables_->kind();
  const auto rounds = [group = workgroup()](std::int64_t rows) { return (rows + group - 1) / group; };
  return 1 + (volumes ? volumes->turns(workgroup()) : 0) +
         rounds(std::max(kind.particles, kind.domains)) *
             (2 + kind.turns.own + kind.turns.gathered + turns_a_tool * tools) +
         rounds(kind.bases) + rounds(kind.volumes);
}

/// As many as the driver's shaders have turns for; half of those are left to what is not counted (loads).
int ComputePasses::steps_a_dispatch() const {
  const std::int64_t fit = limits_.loop_turns / 2 / turns_;
  return static_cast<int>(std::clamp<std::int64_t>(fit, 1, Device::most_steps));
}

void ComputePasses::add_tools(const StepKind& step, ShaderRequest& request) const {
  if (!step.tools) return;
  define_tools(step.grids, request);
  define(request, "NEEDLES", step.needles);
  append(request, tool_files());
  append(request, {"tools/tell_tools.glsl"});
}

Kernel ComputePasses::stepping(const StepKind& step, const ComputeState& state) const {
  const bool one_group = by_one_group(step.pushes());
  ShaderRequest request = gathering(step.loads, one_group);
  define(request, "CUT");
  define(request, "PUSHED", step.pushes());
  append(request, {"step/free_step.glsl"});
  if (step.pushes()) {
    append(request, {"tools/pushed_tables.glsl"});
  } else {
    add_tools(step, request);
  }
  append(request, {"report/measure_step.glsl"});
  define(request, "KEPT_VOLUMES", step.volumes);
  if (step.volumes && step.tools && step.pushes()) {  // what tools hold, volumes leave
    append(request, {"tools/tool_tables.glsl"});
    define_tool_rows(request);
    define(request, "HELD");
  }
  if (step.volumes) append(request, keeping_step_files());
  append(request, {"step/step_pass.glsl", "step/store_step.glsl"});
  if (!one_group) {
    append(request, {"step/step_kernel.glsl"});
    return placed(std::move(request), lanes, state);
  }
  define(request, "ONE_WORKGROUP");
  define(request, "STORED_TERMS", all_terms().any());
  append(request, {"step/store_terms.glsl", "dialect/wait_for_all.glsl"});
  if (step.volumes) append(request, joined({keeping_sums_files(), keeping_end_files()}));
  append(request, {"dialect/workgroup_kernel.glsl"});
  return placed(std::move(request), workgroup(), state);
}

Kernel ComputePasses::freeing(const StepKind& step, const ComputeState& state) const {
  if (!step.pushes()) return {};
  ShaderRequest request = gathering(step.loads);
  define(request, "CUT");
  define(request, "PUSHES");
  append(request, {"step/free_step.glsl", "tools/pushed_tables.glsl"});
  if (step.contacts || step.presses) add_tools(step, request);
  append(request, {"step/free_kernel.glsl"});
  return placed(std::move(request), lanes, state);
}

Kernel ComputePasses::pressing(const StepKind& step, const ComputeState& state) const {
  if (!step.presses) return {};
  ShaderRequest request = gathering(step.loads);
  define(request, "PUSHES");
  append(request, {"step/free_step.glsl", "tools/pushed_tables.glsl"});
  add_tools(step, request);
  append(request, {"tools/press_kernel.glsl"});
  return placed(std::move(request), lanes, state);
}

KeepingKernels ComputePasses::keeping(const StepKind& step, const ComputeState& state) const {
  if (!step.volumes || by_one_group(step.pushes())) return {};
  ShaderRequest sums{.files = joined({common, keeping_sums_files(), {"volume/kept_sums_kernel.glsl"}}),
                     .defines = {{"KEPT_VOLUMES", 1}, {"ONE_WORKGROUP", 1}}};
  tables_->define(sums);
  ShaderRequest end = gathering(step.loads);
  define(end, "KEPT_VOLUMES");
  append(end,
         joined({{"step/free_step.glsl", "report/measure_step.glsl", "volume/kept_tables.glsl"}, keeping_end_files()}));
  append(end, {"volume/kept_step_kernel.glsl"});
  return {placed(std::move(sums), std::min(limits_.invocations, 256), state), placed(std::move(end), lanes, state)};
}

void ComputePasses::set_loads(const ComputeLoads& loads, const ComputeState& state) {
  const ComputeTools* const tools = loads.tools();
  const bool touching = loads.contacts() != nullptr, piercing = loads.needles() != nullptr;
  const std::int64_t turns = turns_a_step(tools ? tools->count() : 0, loads.volumes());
  if (by_one_group(touching || piercing) && turns > limits_.loop_turns) {
    throw Error(ErrorCode::not_supported,
                "expected a step of one group to take at most " + std::to_string(limits_.loop_turns) +
                    " turns of loops, which is where this renderer breaks off, got " + std::to_string(turns) +
                    "; use GlCompute::store (PHYMUL_GL_COMPUTE=store)");
  }
  const StepKind kind{.loads = loads.kind(),
                      .tools = tools != nullptr,
                      .grids = tools && tools->any_grid(),
                      .contacts = touching,
                      .volumes = loads.volumes() != nullptr,
                      .needles = piercing,
                      .presses = piercing && tools->count() > tools->needle_count()};
  auto found = std::ranges::find(stepping_, kind, &Stepping::kind);
  if (found == stepping_.end()) {
    found = stepping_.insert(stepping_.end(), {kind, stepping(kind, state), freeing(kind, state), pressing(kind, state),
                                               keeping(kind, state)});
  }
  if (touching && !contacts_) contacts_.emplace(*library_, *tables_, limits_);
  if (piercing && (!needles_ || needles_->bending() != loads.needles()->any_bends())) {
    NeedlePasses made(*library_, *tables_, limits_, loads.needles()->any_bends());
    needles_ = std::move(made);  // those of before stay where these cannot be made
  }
  now_ = &*found;
  turns_ = turns;
  touching_ = touching ? &loads.rows() : nullptr;
  loads.place(now_->kernel);
  if (now_->keeping) {
    loads.place(now_->keeping.step());
    now_->keeping.place(*loads.volumes());
  }
  if (now_->free) loads.place(now_->free);
  if (now_->press) loads.place(now_->press);
  if (piercing) needles_->set_needles(*loads.needles(), *tools, *loads.pushed());
  if (touching) contacts_->set_contacts(*loads.contacts());
}

void ComputePasses::set_constants(const StepConstants& constants) {
  const auto finite = [](double value) { return std::min(value, double{std::numeric_limits<float>::max()}); };
  const auto set_all = [&](Kernel& kernel) {
    const auto set = [&kernel](const char* name, double value) { kernel.set(name, static_cast<float>(value)); };
    set("largest_acceleration", finite(constants.largest_acceleration));
    set("dt", constants.dt);
    set("inverse_dt", 1.0 / constants.dt);
    set("damping_factor", constants.damping_factor);
    set("runaway_speed", finite(constants.runaway_speed));
    set("speed_at_rest", constants.speed_at_rest);
    set("acceleration_at_rest", constants.acceleration_at_rest);
  };
  set_all(now_->kernel);
  if (now_->keeping) set_all(now_->keeping.step());
  if (now_->free) set_all(now_->free);
  if (now_->press) set_all(now_->press);
  if (now_->kind.needles) needles_->set_step(constants.dt);
  if (touching_) contacts_->set_step(constants.dt);
}

/// What pushes particles between forces and motion, in the order of ToolSet::act and Touching of src/cpu.
void ComputePasses::act_on_free(const ComputeState& state, int number, bool measuring) {
  run(now_->free, state, number, measuring);
  if (now_->kind.needles) needles_->act(number, state.current());
  if (now_->press) run(now_->press, state, number, measuring);
  if (touching_) contacts_->act(*touching_, state.current());
}

void ComputePasses::run(Kernel& kernel, const ComputeState& state, int number, bool measuring) {
  kernel.set("pair", state.current());
  kernel.set("number", number);
  kernel.set("measuring", measuring ? 1 : 0);
  kernel.dispatch(kernel.groups_for(tables_->kind().particles));
}

/// One step, by many groups, from the current state to the free pair.
void ComputePasses::step(const ComputeState& state, int number, bool measuring) {
  evaluate(state);
  if (now_->free) act_on_free(state, number, measuring);
  now_->kernel.set("next_pair", state.free_pair());
  run(now_->kernel, state, number, measuring);
  if (now_->keeping) now_->keeping.run(state, number, tables_->kind().particles);
}

void ComputePasses::dispatch_workgroup(const ComputeState& state, int number, int steps) {
  Kernel& kernel = now_->kernel;
  kernel.set("pair", state.current());
  kernel.set("checkpoint", state.checkpoint());
  kernel.set("number", number);
  kernel.set("steps", steps);
  kernel.dispatch(1);
}

void ComputePasses::steps(ComputeState& state, int first, int count) {
  const bool one_group = by_one_group(now_->kind.pushes());
  const int at_a_time = one_group ? steps_a_dispatch() : 1;
  for (int done = 0, now = 0; done < count; done += now) {
    now = std::min(at_a_time, count - done);
    if (one_group) {
      dispatch_workgroup(state, first + done, now);
    } else {
      step(state, first + done, done == count - 1);
    }
    for (int k = 0; k < now; ++k) state.advance();
  }
}

void ComputePasses::try_step(const ComputeState& state, int number) {
  if (by_one_group(now_->kind.pushes())) return dispatch_workgroup(state, number, 1);
  step(state, number, true);
}

}  // namespace phymul::gl
