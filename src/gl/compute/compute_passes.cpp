// SPDX-License-Identifier: MIT
#include "compute_passes.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace phymul::gl {
namespace {

constexpr int sums_a_lane = 4;  // of facets, before they are worth a dispatch of many groups
constexpr int keeping_group = 256;

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

Kernel ComputePasses::compiled(ShaderRequest request, int group, const ComputeState& state) const {
  tables_->define(request);
  Kernel kernel(*library_, std::move(request), group, limits_);
  tables_->place(kernel);
  state.place(kernel);
  return kernel;
}

ComputePasses::Terms ComputePasses::terms_of(const TermRows& rows, const ComputeState& state) const {
  const BodyKind& kind = tables_->kind();
  ShaderRequest request{.files = common, .defines = {}};
  define(request, "AVERAGED", kind.base_terms && !kind.conservative());
  define(request, "ATTRACTOR_ROWS", rows.attractors);
  define(request, "BASE_ROWS", rows.bases);
  define(request, "VOLUME_ROWS", rows.volumes);
  define(request, "WALL_ROWS", rows.walls);
  define(request, "DOMAIN_ROWS", rows.domains);
  define(request, "SCALED_STIFFNESS", rows.scaled);
  if (rows.attractors || rows.bases) append(request, base_kernel());
  if (rows.attractors) append(request, attractor_files(kind));
  if (rows.bases && kind.attractors) append(request, {"step/force_of.glsl"});
  if (rows.bases) append(request, {"step/bases_pass.glsl"});
  if (rows.volumes) append(request, joined({volume_kernel(), {"step/volumes_pass.glsl"}}));
  if (rows.walls) append(request, joined({wall_kernel(), {"step/walls_pass.glsl"}}));
  if (rows.domains) {
    append(request, domain_files(kind));
    if (kind.dissipates()) append(request, {"step/kept_strains.glsl"});
    append(request, {"step/domains_pass.glsl"});
  }
  append(request, {"step/terms_kernel.glsl"});
  Terms terms{.kernel = compiled(std::move(request), lanes, state)};
  const auto add = [&terms](const char* name, bool wanted, int count) {
    const int groups = wanted ? terms.kernel.groups_for(count) : 0;
    terms.kernel.set(name, groups);
    terms.groups += groups;
  };
  add("attractor_groups", rows.attractors, kind.particles);
  add("base_groups", rows.bases, kind.bases);
  add("volume_groups", rows.volumes, kind.volumes);
  add("wall_groups", rows.walls, kind.walls);
  add("domain_groups", rows.domains, kind.domains);
  terms.kernel.set("base_rows_count", kind.bases);
  terms.kernel.set("volume_count", kind.volumes);
  terms.kernel.set("wall_count", kind.walls);
  terms.kernel.set("domain_count", kind.domains);
  return terms;
}

/// With the averaged reaction bases read forces that must be there.
std::vector<ComputePasses::Terms> ComputePasses::compiled_terms(bool scaled, const ComputeState& state) const {
  const BodyKind& kind = tables_->kind();
  const bool apart = kind.attractors && kind.base_terms;
  std::vector<Terms> terms;
  const auto add = [&](const TermRows& rows) {
    if (rows.any()) terms.push_back(terms_of(rows, state));
  };
  add({.attractors = kind.attractors,
       .bases = kind.base_terms && !apart,
       .volumes = kind.volumes > 0,
       .walls = kind.walls > 0,
       .domains = kind.domains > 0,
       .scaled = scaled});
  if (apart) add({.bases = true});
  return terms;
}

/// Up to free_step.glsl.
ShaderRequest ComputePasses::gathering(const StepKind& step) const {
  ShaderRequest request{.files = common, .defines = {}};
  define_gathering(tables_->kind(), step.loads, request);
  append(request, gathering_files());
  append(request, {"step/free_step.glsl"});
  return request;
}

/// The same for a pass between forces and motion.
ShaderRequest ComputePasses::pushing(const StepKind& step) const {
  ShaderRequest request = gathering(step);
  define(request, "CUT");
  define(request, "PUSHES");
  define(request, "HOST_STEP", step.on_host);
  append(request, {"tools/pushed_tables.glsl"});
  return request;
}

void ComputePasses::add_tools(const StepKind& step, ShaderRequest& request) const {
  define_tools(step.grids, request);
  append(request, tool_files());
  append(request, {"tools/tell_tools.glsl"});
}

Kernel ComputePasses::stepping(const StepKind& step, const ComputeState& state) const {
  ShaderRequest request = gathering(step);
  define(request, "CUT");
  define(request, "PUSHED", step.pushes());
  define(request, "HOST_STEP", step.on_host);
  if (step.pushes()) append(request, {"tools/pushed_tables.glsl"});
  if (step.on_host) append(request, {"step/host_pushes.glsl"});
  if (step.tools && !step.pushes()) add_tools(step, request);
  append(request, {"report/measure_step.glsl"});
  define(request, "KEPT_VOLUMES", step.volumes);
  if (step.volumes) {
    append(request, {"volume/kept_tables.glsl", "volume/kept_facet.glsl", "volume/kept_along_pass.glsl"});
  }
  append(request, {"step/step_pass.glsl", "step/step_kernel.glsl"});
  return compiled(std::move(request), lanes, state);
}

Kernel ComputePasses::freeing(const StepKind& step, const ComputeState& state) const {
  ShaderRequest request = pushing(step);
  if (step.tools) add_tools(step, request);
  append(request, {"step/free_pass.glsl", "step/free_kernel.glsl"});
  return compiled(std::move(request), lanes, state);
}

Kernel ComputePasses::gathering_rows(const ComputeState& state) const {
  ShaderRequest request{.files = common, .defines = {{"PUSHES", 1}}};
  append(request, {"tools/pushed_tables.glsl", "step/gather_pass.glsl", "step/gather_kernel.glsl"});
  return compiled(std::move(request), lanes, state);
}

Kernel ComputePasses::pulling(const StepKind& step, const ComputeState& state) const {
  ShaderRequest request{.files = common, .defines = {}};
  define(request, "PUSHES");  // it writes rows of loads
  define_joints(step.joints_on_tools, request);
  append(request, joint_files(step.joints_on_tools));
  append(request, {"joints/joint_kernel.glsl"});
  return compiled(std::move(request), lanes, state);
}

/// Of one group, or of many where these sum facets alone.
Kernel ComputePasses::keep_summing(const ComputeState& state) const {
  ShaderRequest request{.files = common, .defines = {{"KEPT_VOLUMES", 1}, {"ONE_WORKGROUP", 1}}};
  append(request, {"volume/kept_tables.glsl", "volume/kept_facet.glsl", "volume/kept_sums_pass.glsl",
                   "volume/volume_root.glsl", "volume/kept_root_pass.glsl", "volume/kept_sums_kernel.glsl"});
  return compiled(std::move(request), std::min(limits_.invocations, keeping_group), state);
}

Kernel ComputePasses::keep_ending(const StepKind& step, const ComputeState& state) const {
  ShaderRequest request = gathering(step);
  define(request, "KEPT_VOLUMES");
  append(request, {"report/measure_step.glsl", "volume/kept_tables.glsl", "volume/kept_step_pass.glsl",
                   "volume/kept_step_kernel.glsl"});
  return compiled(std::move(request), lanes, state);
}

ComputePasses::Stepping ComputePasses::compiled(const StepKind& kind, const ComputeState& state) const {
  Stepping made;
  made.kind = kind;
  made.step = stepping(kind, state);
  if (kind.pushes()) made.free = freeing(kind, state);
  if (kind.on_host) made.gather = gathering_rows(state);
  if (kind.loads.joints) made.joints = pulling(kind, state);
  if (kind.volumes) {
    made.keep_sums = keep_summing(state);
    made.keep_end = keep_ending(kind, state);
  }
  return made;
}

void ComputePasses::set_loads(ComputeLoads& loads, const ComputeState& state) {
  const ComputeTools* const tools = loads.tools();
  const bool touching = loads.contacts() != nullptr;
  const StepKind kind{.loads = loads.kind(),
                      .tools = tools != nullptr,
                      .grids = tools && tools->any_grid(),
                      .contacts = touching,
                      .volumes = loads.volumes() != nullptr,
                      .on_host = loads.open() != nullptr,
                      .joints_on_tools = loads.joints() && loads.joints()->any_tool()};
  std::vector<Terms>& terms = kind.loads.scaled ? scaled_terms_ : terms_;
  if (terms.empty()) terms = compiled_terms(kind.loads.scaled, state);
  auto found = std::ranges::find(stepping_, kind, &Stepping::kind);
  if (found == stepping_.end()) found = stepping_.insert(stepping_.end(), compiled(kind, state));
  if (touching && !contacts_) contacts_.emplace(*library_, *tables_, limits_);
  now_ = &*found;
  loads_ = &loads;
  terms_now_ = &terms;
  if (kind.loads.scaled) {
    for (Terms& scaled : terms) loads.place(scaled.kernel);
  }
  now_->for_each([&](Kernel& kernel) { loads.place(kernel); });
  if (touching) contacts_->set_contacts(loads);
}

void ComputePasses::set_constants(const StepConstants& constants) {
  now_->for_each([&](Kernel& kernel) {
    const auto set = [&kernel](const char* name, double value) { kernel.set(name, to_float(value)); };
    set("largest_acceleration", constants.largest_acceleration);
    set("dt", constants.dt);
    set("inverse_dt", 1.0 / constants.dt);
    set("damping_factor", constants.damping_factor);
    set("runaway_speed", constants.runaway_speed);
    set("speed_at_rest", constants.speed_at_rest);
    set("acceleration_at_rest", constants.acceleration_at_rest);
    kernel.set("tools_at_once", constants.tools_at_once ? 1 : 0);
  });
  dt_ = constants.dt;
  last_dt_ = constants.last_dt > 0.0 ? constants.last_dt : constants.dt;
  if (now_->kind.contacts) contacts_->set_step(constants.dt);
}

void ComputePasses::run(Kernel& kernel, const ComputeState& state, int number, bool measuring) const {
  kernel.set("pair", state.current());
  kernel.set("next_pair", state.free_pair());
  kernel.set("number", number);
  kernel.set("measuring", measuring ? 1 : 0);
  kernel.dispatch(kernel.groups_for(tables_->kind().particles));
}

void ComputePasses::dispatch_terms(const ComputeState& state, int number) {
  for (Terms& terms : *terms_now_) {
    terms.kernel.set("pair", state.current());
    if (tables_->kind().dissipates()) {
      terms.kernel.set("strains_place", state.strains_row(state.current()));
      terms.kernel.set("next_strains_place", state.strains_row(state.free_pair()));
      terms.kernel.set("strains_fresh", number == 1 && state.strains_fresh() ? 1 : 0);
      terms.kernel.set("inverse_last_dt", static_cast<float>(1.0 / (number == 1 ? last_dt_ : dt_)));
    }
    terms.kernel.dispatch(terms.groups);
  }
}

/// What pushes particles between forces and motion comes in the order of ToolSet::act and Touching of src/interaction.
void ComputePasses::open(const ComputeState& state, int number, bool measuring) {
  dispatch_terms(state, number);
  if (loads_->joints()) pull(state, number);
  if (now_->kind.pushes()) run(now_->free, state, number, measuring);
  if (now_->kind.contacts) contacts_->act(state.current());
}

void ComputePasses::gather(const ComputeState& state) {
  const ComputeOpenStep& open = *loads_->open();
  if (open.asked_count() == 0) return;
  now_->gather.set("pair", state.current());
  now_->gather.set("gather_count", open.asked_count());
  now_->gather.set("gathered_place", open.gathered_row());
  now_->gather.dispatch(now_->gather.groups_for(open.asked_count()));
}

void ComputePasses::close(const ComputeState& state, int number, bool measuring) {
  if (loads_->open()) now_->step.set("push_count", loads_->open()->push_count());
  run(now_->step, state, number, measuring);
  if (now_->kind.volumes) keep(state, number);
}

void ComputePasses::pull(const ComputeState& state, int number) const {
  const ComputeJoints& joints = *loads_->joints();
  const int next = joints.state_row(state.free_pair());
  Kernel& kernel = now_->joints;
  kernel.set("pair", state.current());
  kernel.set("joint_instant", number - 1);
  kernel.set("joint_state_place", joints.state_row(state.current()));
  kernel.set("next_joint_state_place", next);
  kernel.dispatch(kernel.groups_for(joints.count()));
  (now_->kind.pushes() ? now_->free : now_->step).set("joint_state_place", next);
}

void ComputePasses::keep(const ComputeState& state, int number) const {
  Kernel& sums = now_->keep_sums;
  const int facet_sums = loads_->volumes()->facet_sums();
  const bool apart = facet_sums > sums_a_lane * sums.group();
  sums.set("next_pair", state.free_pair());
  sums.set("number", number);
  if (apart) {
    sums.set("first_level", -1);
    sums.dispatch(sums.groups_for(facet_sums));
  }
  sums.set("first_level", apart ? 1 : 0);
  sums.dispatch(1);
  run(now_->keep_end, state, number, true);
}

namespace {

/// Of a group that works alone. A processor that plays GPU takes up its lanes one after another at every wait, so fewer
/// of them wait less; that is where turns are limited.
int lone_group(const ComputeLimits& limits) {
  const bool limited = limits.loop_turns < std::numeric_limits<std::int64_t>::max();
  return static_cast<int>(std::bit_floor(static_cast<unsigned>(std::min(limits.invocations, limited ? 64 : 256))));
}

}  // namespace

ContactPasses::ContactPasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits)
    : tables_(&tables),
      group_(lone_group(limits)),
      most_turns_(static_cast<int>(std::min<std::int64_t>(limits.loop_turns / 2, std::numeric_limits<int>::max()))) {
  const auto compiled = [&](ShaderFiles files, int group, bool is_alone = false) {
    ShaderRequest request{.files = {"dialect/dialect_compute.glsl", "dialect/kernel_language.glsl",
                                    "tools/pushed_tables.glsl", "contact/contact_tables.glsl"},
                          .defines = {{"PUSHES", 1}, {"OWN_BLOCK", 1}}};
    request.files.insert(request.files.end(), files.begin(), files.end());
    if (is_alone) request.defines.emplace_back("ONE_WORKGROUP", 1);
    tables.define(request);
    return Kernel(library, std::move(request), group, limits);
  };
  const auto alone = [&](ShaderFiles files) {
    return compiled(joined({{"dialect/lone_group.glsl", "contact/contact_group.glsl"}, std::move(files)}), group_,
                    true);
  };
  grid_ = alone({"contact/contact_range.glsl", "contact/contact_grid_kernel.glsl"});
  order_ = compiled({"contact/contact_order_kernel.glsl"}, lanes);
  search_ = compiled({"tools/closest_point.glsl", "contact/contact_range.glsl", "contact/contact_nearest.glsl",
                      "contact/contact_search_kernel.glsl"},
                     lanes);
  queue_ = alone({"contact/contact_queue_kernel.glsl"});
  press_ = alone({"contact/contact_law.glsl", "contact/contact_press_kernel.glsl"});
  part_ = compiled({"contact/contact_law.glsl", "contact/contact_part_kernel.glsl"}, lanes);
}

void ContactPasses::set_contacts(const ComputeLoads& loads) {
  for (Kernel* kernel : {&grid_, &order_, &search_, &queue_, &press_, &part_}) loads.place(*kernel);
  press_.set("most_turns", most_turns_);
  loads_ = &loads;
}

void ContactPasses::set_step(double dt) {
  grid_.set("dt", static_cast<float>(dt));
  press_.set("inverse_dt", static_cast<float>(1.0 / dt));
  part_.set("inverse_dt", static_cast<float>(1.0 / dt));
}

void ContactPasses::order(const ComputeContacts::Lists& lists, std::int64_t most) {
  const auto set = [this](const char* name, std::int64_t word) { order_.set(name, static_cast<int>(word)); };
  set("first_list", lists.first);
  set("owner_count", lists.owners);
  set("raw_list", lists.raw);
  set("owner_list", lists.owner);
  set("to_list", lists.to);
  set("rank_list", lists.rank);
  order_.dispatch(order_.groups_for(most));
}

/// As many as finish the sweeps however contacts depend on each other: each phase of a dispatch presses at least one.
/// One where turns are not limited; those after the last one needed find nothing to do.
int ContactPasses::press_dispatches() const {
  const std::int64_t contacts = loads_->contacts()->meetings();
  const std::int64_t phases = most_turns_ / (3 + 3 * ((contacts + group_ - 1) / group_));
  const std::int64_t needed = contacts * loads_->contacts()->rounds();
  return static_cast<int>((needed + phases - 1) / phases);
}

void ContactPasses::act(int pair) {
  const ComputeContacts& contacts = *loads_->contacts();
  loads_->rows().bind(constant_words_binding);  // in place of constants, which these passes do not read
  grid_.set("pair", pair);
  grid_.dispatch(1);
  order(contacts.bucket_lists(), contacts.triangles());
  search_.dispatch(search_.groups_for(contacts.particles()));
  queue_.dispatch(1);
  order(contacts.queue_lists(), 4 * contacts.meetings());
  for (int k = press_dispatches(); k > 0; --k) press_.dispatch(1);
  part_.dispatch(part_.groups_for(contacts.particles()));
  tables_->bind();
}

}  // namespace phymul::gl
