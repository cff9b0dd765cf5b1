// SPDX-License-Identifier: MIT
#include "fragment_passes.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace phymul::gl {
namespace {

const ShaderFiles common{"dialect/dialect_fragment.glsl", "step/tables.glsl", "dialect/kernel_language.glsl"};

}  // namespace

FragmentPasses::FragmentPasses(const FragmentTables& tables, const FragmentStrains* strains,
                               const ShaderLibrary& library)
    : tables_(&tables), strains_(strains), library_(&library) {
  if (tables.kind().attractors) add_attractors();
  if (tables.kind().base_terms) add_bases();
  add_volumes();
  if (tables.kind().walls > 0) add_walls();
  if (tables.kind().domains > 0) add_domains();
}

Pass FragmentPasses::term_pass(ShaderRequest request, const Texture& target, int rows) const {
  define_kernels(tables_->kind(), request);
  Pass pass(*library_, request);
  tables_->bind(pass);
  pass.set_rows(target, rows);
  return pass;
}

void FragmentPasses::add(ShaderRequest request, const std::vector<Attachment>& targets, int rows) {
  before_.push_back({term_pass(std::move(request), *targets.front().texture, rows), Framebuffer(targets), rows});
}

void FragmentPasses::add_attractors() {
  const BodyKind& kind = tables_->kind();
  force_ = Texture::target(kind.particles, "forces of attractors");
  add({.files = joined({common, base_kernel(), attractor_files(kind)}), .defines = {}}, {{&force_}}, kind.particles);
}

void FragmentPasses::add_bases() {
  const BodyKind& kind = tables_->kind();
  const int corners = kind.conservative() ? 4 : 3;
  base_terms_ = Texture::target(kind.bases, "forces of bases", corners);
  ShaderRequest request{.files = joined({common, base_kernel(), {"step/force_of.glsl", "step/bases_pass.glsl"}}),
                        .defines = {}};
  if (!kind.conservative()) request.defines.emplace_back("AVERAGED", 1);
  std::vector<Attachment> layers;
  for (int corner = 0; corner < corners; ++corner) layers.push_back({&base_terms_, corner});
  add(std::move(request), layers, kind.bases);
  if (force_) before_.back().pass.input("force", force_);
}

void FragmentPasses::add_volumes() {
  const BodyKind& kind = tables_->kind();
  if (kind.volumes > 0) {
    volume_terms_ = Texture::target(kind.volumes, "forces of volumes", 4);
    add({.files = joined({common, volume_kernel(), {"step/volumes_pass.glsl"}}), .defines = {}},
        {{&volume_terms_, 0}, {&volume_terms_, 1}, {&volume_terms_, 2}, {&volume_terms_, 3}}, kind.volumes);
  }
}

void FragmentPasses::add_walls() {
  const Index walls = tables_->kind().walls;
  wall_terms_ = Texture::target(walls, "forces of walls", 4);
  add({.files = joined({common, wall_kernel(), {"step/walls_pass.glsl"}}), .defines = {}},
      {{&wall_terms_, 0}, {&wall_terms_, 1}, {&wall_terms_, 2}, {&wall_terms_, 3}}, walls);
}

void FragmentPasses::add_domains() {
  const BodyKind& kind = tables_->kind();
  domain_terms_ = Texture::target(kind.domains, "stresses of domains", 3);
  add(domains_request(), {{&domain_terms_, 0}, {&domain_terms_, 1}, {&domain_terms_, 2}}, kind.domains);
  if (!strains_) return;
  const ShaderFiles passes{"step/kept_strains.glsl", "step/strains_pass.glsl"};
  strains_pass_ = term_pass({.files = joined({common, domain_files(kind), passes}), .defines = {}},
                            strains_->kept.texture(0), kind.domains);
}

ShaderRequest FragmentPasses::domains_request() const {
  return {.files = joined({common, domain_files(tables_->kind()), {"step/domains_pass.glsl"}}), .defines = {}};
}

ShaderRequest FragmentPasses::gathering(const LoadKind& loads) const {
  ShaderRequest request{.files = joined({common, gathering_files()}), .defines = {{"CUT", 1}}};
  define_kernels(tables_->kind(), request);
  define_gathering(tables_->kind(), loads, request);
  return request;
}

void FragmentPasses::bind_terms(Pass& pass) const {
  if (force_) pass.input("force", force_);
  if (base_terms_) pass.input("base_terms", base_terms_);
  if (volume_terms_) pass.input("volume_terms", volume_terms_);
  if (wall_terms_) pass.input("wall_terms", wall_terms_);
  if (domain_terms_) pass.input("domain_terms", domain_terms_);
}

/// Of those that move particles, or tell where they would go.
Pass FragmentPasses::compiled(const StepKind& kind, const ShaderFiles& passes) const {
  ShaderRequest request = gathering(kind.loads);
  request.files.emplace_back("step/free_step.glsl");
  if (kind.tools) {
    define_tools(kind.grids, request);
    request.files.insert(request.files.end(), tool_files().begin(), tool_files().end());
    request.defines.emplace_back("NET_APART", 1);
  }
  if (kind.on_host) request.defines.emplace_back("HOST_STEP", 1);
  if (kind.on_host && passes.back() == "step/step_pass.glsl") {
    request.defines.emplace_back("PUSHED", 1);
    request.files.insert(request.files.end(), {"tools/pushed_tables.glsl", "step/host_pushes.glsl"});
  }
  if (kind.volumes) request.defines.emplace_back("KEPT_VOLUMES", 1);
  request.files.insert(request.files.end(), passes.begin(), passes.end());
  Pass moving(*library_, request);
  tables_->bind(moving);
  bind_terms(moving);
  if (kind.tools) moving.input("net", net_);
  return moving;
}

FragmentPasses::Stepping FragmentPasses::compiled(const StepKind& kind) const {
  Stepping stepping;
  stepping.kind = kind;
  if (kind.tools) {
    ShaderRequest reaction = gathering(kind.loads);
    reaction.files.emplace_back("step/reaction_pass.glsl");
    stepping.reaction = Pass(*library_, reaction);
    tables_->bind(stepping.reaction);
    bind_terms(stepping.reaction);
    stepping.tools = compiled(kind, {"tools/tools_pass.glsl"});
  }
  if (kind.loads.scaled) {
    ShaderRequest domains = domains_request();
    domains.defines.emplace_back("SCALED_STIFFNESS", 1);
    stepping.domains = term_pass(std::move(domains), domain_terms_, tables_->kind().domains);
  }
  if (kind.loads.joints) {
    ShaderRequest joints{.files = joined({common, joint_files(kind.joints_on_tools), {"joints/joint_pass.glsl"}}),
                         .defines = {}};
    define_kernels(tables_->kind(), joints);
    define_joints(kind.joints_on_tools, joints);
    stepping.joints = Pass(*library_, joints);
  }
  if (kind.on_host) {
    stepping.free = compiled(kind, {"step/free_pass.glsl"});
    ShaderRequest gather{.files = joined({common, {"tools/pushed_tables.glsl", "step/gather_pass.glsl"}}),
                         .defines = {}};
    define_kernels(tables_->kind(), gather);
    stepping.gather = Pass(*library_, gather);
  }
  stepping.step = compiled(kind, {"report/measure_step.glsl", "step/step_pass.glsl"});
  if (kind.volumes) compile_keeping(stepping);
  return stepping;
}

void FragmentPasses::compile_keeping(Stepping& stepping) const {
  stepping.along =
      compiled(stepping.kind, {"volume/kept_tables.glsl", "volume/kept_facet.glsl", "volume/kept_along_pass.glsl"});
  stepping.end =
      compiled(stepping.kind, {"report/measure_step.glsl", "volume/kept_tables.glsl", "volume/kept_step_pass.glsl"});
  const auto plain = [this](ShaderRequest request) {
    define_kernels(tables_->kind(), request);
    return Pass(*library_, request);
  };
  const ShaderFiles sums =
      joined({common, {"volume/kept_tables.glsl", "volume/kept_facet.glsl", "volume/kept_sums_pass.glsl"}});
  stepping.facets = plain({.files = sums, .defines = {{"FACETS", 1}}});
  stepping.sums = plain({.files = sums, .defines = {}});
  stepping.roots = plain(
      {.files = joined({common, {"volume/kept_tables.glsl", "volume/volume_root.glsl", "volume/kept_root_pass.glsl"}}),
       .defines = {}});
}

void FragmentPasses::set_scene(FragmentScene& scene) {
  const auto before = std::pair(now_, scene_);
  const std::size_t known = stepping_.size();
  scene_ = &scene;
  try {
    make_passes({.loads = scene.loads.kind(),
                 .tools = scene.tools_act(),
                 .grids = scene.tools_act() && scene.tools->any_grid(),
                 .volumes = scene.volumes.has_value(),
                 .on_host = scene.open.has_value(),
                 .joints_on_tools = scene.joints && scene.joints->any_tool()});
    bind_scene();
  } catch (...) {
    std::tie(now_, scene_) = before;
    while (stepping_.size() > known) stepping_.pop_back();
    if (now_) bind_scene();  // what passes know already they look up no more, so that nothing can fail
    throw;
  }
}

void FragmentPasses::make_passes(const StepKind& kind) {
  if (kind.tools && !net_) {
    Texture net = Texture::target(tables_->kind().particles, "net forces", 2);
    net_target_ = Framebuffer({{&net, 0}, {&net, 1}});
    net_ = std::move(net);
  }
  auto found = std::ranges::find(stepping_, kind, &Stepping::kind);
  if (found == stepping_.end()) found = stepping_.insert(stepping_.end(), compiled(kind));
  now_ = &*found;
}

void FragmentPasses::bind_scene() {
  scene_->loads.bind(now_->step);
  if (scene_->loads.kind().scaled) scene_->loads.bind_factors(now_->domains);
  if (now_->kind.tools) {
    scene_->loads.bind(now_->reaction);
    scene_->loads.bind(now_->tools);
    scene_->tools->bind(now_->tools);
    scene_->tools->bind(now_->step);
  }
  if (scene_->volumes) bind_volumes();
  if (scene_->open) bind_open();
  if (scene_->joints) bind_joints();
}

void FragmentPasses::bind_joints() {
  scene_->joints->bind(now_->joints);
  if (scene_->joints->any_tool()) scene_->tools->bind(now_->joints);
  scene_->joints->bind_gathering(gathering_pass());
}

void FragmentPasses::bind_open() {
  scene_->loads.bind(now_->free);
  scene_->open->bind(now_->gather);
  scene_->open->bind(now_->step);
  scene_->open->bind_pushes(now_->step);
}

void FragmentPasses::bind_volumes() {
  for (Pass* const pass : {&now_->along, &now_->end}) scene_->loads.bind(*pass);
  for (Pass* const pass : {&now_->along, &now_->facets, &now_->sums, &now_->roots, &now_->end})
    scene_->volumes->bind(*pass);
}

void FragmentPasses::set_constants(const StepConstants& constants) {
  dt_ = constants.dt;
  last_dt_ = constants.last_dt > 0.0 ? constants.last_dt : constants.dt;
  gathering_pass().set("largest_acceleration", to_float(constants.largest_acceleration));
  if (scene_->joints) {
    now_->joints.set("inverse_dt", static_cast<float>(1.0 / constants.dt));
    now_->joints.set("tools_at_once", constants.tools_at_once ? 1 : 0);
  }
  const auto set_motion = [&](Pass& pass) {
    pass.set("dt", static_cast<float>(constants.dt));
    pass.set("inverse_dt", static_cast<float>(1.0 / constants.dt));
    pass.set("damping_factor", static_cast<float>(constants.damping_factor));
  };
  set_motion(now_->step);
  if (now_->kind.tools) set_motion(now_->tools);
  if (scene_->volumes) set_motion(now_->end);
  if (scene_->open) set_motion(now_->free);
  Pass& end = scene_->volumes ? now_->end : now_->step;
  const auto set = [&](const char* name, double value) { end.set(name, to_float(value)); };
  set("runaway_speed", constants.runaway_speed);
  set("speed_at_rest", constants.speed_at_rest);
  set("acceleration_at_rest", constants.acceleration_at_rest);
}

void FragmentPasses::prepare(Pass& pass, const FragmentState& state, int batch_step) const {
  pass.input("displacement", state.displacement());
  pass.input("velocity", state.velocity());
  pass.set("instant", batch_step - 1);
  pass.set("batch_step", batch_step);
  pass.set("gravity", scene_->loads.gravity(static_cast<std::size_t>(batch_step - 1)));
}

void FragmentPasses::draw_terms(const FragmentState& state, int batch_step) {
  const auto remember = [&](Pass& pass) {
    strains_->bind(pass, state.current());
    pass.set("strains_fresh", batch_step == 1 && state.strains_fresh() ? 1 : 0);
    pass.set("inverse_last_dt", static_cast<float>(1.0 / (batch_step == 1 ? last_dt_ : dt_)));
  };
  for (Drawing& drawing : before_) {
    const bool last = &drawing == &before_.back();  // of domains, where there are some
    Pass& pass = last && scene_->loads.kind().scaled ? now_->domains : drawing.pass;
    pass.input("displacement", state.displacement());
    if (last && strains_) remember(pass);
    pass.draw(drawing.target);
  }
  if (!strains_) return;
  strains_pass_.input("displacement", state.displacement());
  remember(strains_pass_);
  strains_pass_.draw(strains_->kept.target(state.free_pair()));
}

/// What pushes between forces and motion comes in the order of ToolSet::act and Touching of src/interaction.
void FragmentPasses::open(const FragmentState& state, int batch_step) {
  draw_terms(state, batch_step);
  if (scene_->joints) pull(state, batch_step);
  if (now_->kind.tools) {
    Pass& reaction = now_->reaction;
    reaction.input("displacement", state.displacement());
    reaction.set_rows(net_, tables_->kind().particles);
    reaction.set("instant", batch_step - 1);
    reaction.draw(net_target_);
    tell(state, batch_step);
  }
  if (!scene_->open) return;
  prepare(now_->free, state, batch_step);
  now_->free.set_rows(state.displacement(), tables_->kind().particles);
  now_->free.draw(scene_->open->target());
}

void FragmentPasses::gather(const FragmentState& state) {
  now_->gather.input("displacement", state.displacement());
  scene_->open->gather(now_->gather);
}

void FragmentPasses::close(const FragmentState& state, int batch_step, bool measuring) {
  Pass& step = now_->step;
  prepare(step, state, batch_step);
  if (scene_->open) step.set("push_count", scene_->open->push_count());
  step.set_rows(state.displacement(), tables_->kind().particles);
  step.draw(scene_->volumes ? scene_->volumes->free_target() : state.next(measuring));
  if (scene_->volumes) keep(state, batch_step, measuring);
}

void FragmentPasses::pull(const FragmentState& state, int batch_step) {
  Pass& joints = now_->joints;
  joints.input("displacement", state.displacement());
  joints.input("velocity", state.velocity());
  joints.input("joint_state", scene_->joints->state.texture(state.current()));
  joints.set("joint_instant", batch_step - 1);
  joints.set_rows(scene_->joints->state.texture(0), scene_->joints->count());
  joints.draw(scene_->joints->state.target(state.free_pair()));
  gathering_pass().input("joint_state", scene_->joints->state.texture(state.free_pair()));
}

void FragmentPasses::tell(const FragmentState& state, int batch_step) {
  prepare(now_->tools, state, batch_step);
  scene_->tools->tell(now_->tools);
}

void FragmentPasses::keep(const FragmentState& state, int batch_step, bool measuring) {
  prepare(now_->along, state, batch_step);
  scene_->volumes->follow_gradient(now_->along);
  scene_->volumes->sum(now_->facets, now_->sums);
  scene_->volumes->find_roots(now_->roots, batch_step);
  scene_->volumes->bind_roots(now_->end);
  prepare(now_->end, state, batch_step);
  now_->end.set_rows(state.displacement(), tables_->kind().particles);
  now_->end.draw(state.next(measuring));
}

}  // namespace phymul::gl
