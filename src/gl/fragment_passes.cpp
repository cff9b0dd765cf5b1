// SPDX-License-Identifier: MIT
#include "gl/fragment_passes.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace phymul::gl {
namespace {

const ShaderFiles common{"dialect_fragment.glsl", "tables.glsl", "vector3.glsl"};

}  // namespace

FragmentPasses::FragmentPasses(const FragmentTables& tables, const ShaderLibrary& library, bool four)
    : tables_(&tables), library_(&library), four_(four) {
  if (tables.kind().attractors) add_attractors();
  if (tables.kind().base_terms) add_bases();
  add_volumes_and_cells();
  if (!four_) return;
  net_ = Texture::target(tables.kind().particles, TexelFormat::rgba32f, "net forces");
  net_target_ = Framebuffer({{&net_}});
}

void FragmentPasses::add(ShaderRequest request, const std::vector<Attachment>& targets, int rows) {
  define_kernels(tables_->kind(), request);
  Drawing drawing{Pass(*library_, std::move(request)), Framebuffer(targets), rows};
  tables_->bind(drawing.pass);
  drawing.pass.set_rows(*targets.front().texture, rows);
  before_.push_back(std::move(drawing));
}

void FragmentPasses::add_attractors() {
  const BodyKind& kind = tables_->kind();
  force_ = Texture::target(kind.particles, TexelFormat::rgba32f, "forces of attractors");
  ShaderRequest request{.files = joined({common, base_kernel(kind), attractor_files(kind)}), .defines = {}};
  if (kind.options.area_exponent != 0.0) request.defines.emplace_back("AREA_EXPONENT", 1);
  if (!four_) return add(std::move(request), {{&force_}}, kind.particles);
  request.defines.emplace_back("FOUR_PASSES", 1);
  pull_ = Texture::target(kind.particles, TexelFormat::rgba32f, "pulls of attractors");
  add(std::move(request), {{&pull_}}, kind.particles);
  add({.files = joined({common, {"force_pass.glsl"}}), .defines = {}}, {{&force_}}, kind.particles);
  before_.back().pass.input("pull", pull_);
}

void FragmentPasses::add_bases() {
  const BodyKind& kind = tables_->kind();
  const int corners = kind.conservative() ? 4 : 3;
  base_terms_ = Texture::target(kind.bases, TexelFormat::rgba32f, "forces of bases", corners);
  ShaderRequest request{.files = joined({common, base_kernel(kind), {"force_of.glsl", "bases_pass.glsl"}}),
                        .defines = {}};
  if (kind.options.area_exponent != 0.0) request.defines.emplace_back("AREA_EXPONENT", 1);
  if (!kind.conservative()) request.defines.emplace_back("AVERAGED", 1);
  std::vector<Attachment> layers;
  for (int corner = 0; corner < corners; ++corner) layers.push_back({&base_terms_, corner});
  add(std::move(request), layers, kind.bases);
  if (force_) before_.back().pass.input("force", force_);
}

void FragmentPasses::add_volumes_and_cells() {
  const BodyKind& kind = tables_->kind();
  if (kind.volumes > 0) {
    volume_terms_ = Texture::target(kind.volumes, TexelFormat::rgba32f, "forces of volumes", 4);
    add({.files = joined({common, volume_kernel(), {"volumes_pass.glsl"}}), .defines = {}},
        {{&volume_terms_, 0}, {&volume_terms_, 1}, {&volume_terms_, 2}, {&volume_terms_, 3}}, kind.volumes);
  }
  if (kind.cells > 0) {
    cell_terms_ = Texture::target(kind.cells, TexelFormat::rgba32f, "stresses of cells", 3);
    add({.files = joined({common, {"delta_base.glsl"}, cell_kernel(), {"cells_pass.glsl"}}), .defines = {}},
        {{&cell_terms_, 0}, {&cell_terms_, 1}, {&cell_terms_, 2}}, kind.cells);
  }
}

ShaderRequest FragmentPasses::gathering(const LoadKind& loads, const char* pass) const {
  const BodyKind& kind = tables_->kind();
  ShaderRequest request{.files = joined({common,
                                         {"delta_spring.glsl", "integrate_displacement.glsl", "force_of.glsl",
                                          "terms_of.glsl", "net_force.glsl"}}),
                        .defines = {}};
  request.files.emplace_back(pass);
  define_kernels(kind, request);
  define_gathering(kind, loads, request);
  return request;
}

void FragmentPasses::bind_terms(Pass& pass) const {
  if (force_) pass.input("force", force_);
  if (base_terms_) pass.input("base_terms", base_terms_);
  if (volume_terms_) pass.input("volume_terms", volume_terms_);
  if (cell_terms_) pass.input("cell_terms", cell_terms_);
}

FragmentPasses::Stepping FragmentPasses::compiled(const LoadKind& loads) const {
  Stepping stepping;
  stepping.loads = loads;
  ShaderRequest step = gathering(loads, "step_pass.glsl");
  if (four_) {
    step.defines.emplace_back("FOUR_PASSES", 1);
    ShaderRequest reaction = gathering(loads, "reaction_pass.glsl");
    reaction.defines.emplace_back("CUT", 1);
    stepping.reaction = Pass(*library_, std::move(reaction));
    tables_->bind(stepping.reaction);
    bind_terms(stepping.reaction);
  }
  step.defines.emplace_back("CUT", 1);
  stepping.step = Pass(*library_, std::move(step));
  tables_->bind(stepping.step);
  bind_terms(stepping.step);
  if (four_) stepping.step.input("net", net_);
  return stepping;
}

void FragmentPasses::set_loads(const FragmentLoads& loads) {
  loads_ = &loads;
  auto found = std::ranges::find(stepping_, loads.kind(), &Stepping::loads);
  if (found == stepping_.end()) found = stepping_.insert(stepping_.end(), compiled(loads.kind()));
  now_ = &*found;
  loads.bind(now_->step);
  if (four_) loads.bind(now_->reaction);
}

void FragmentPasses::set_constants(const StepConstants& constants) {
  const auto finite = [](double value) { return std::min(value, double{std::numeric_limits<float>::max()}); };
  Pass& cutting = four_ ? now_->reaction : now_->step;
  cutting.set("largest_acceleration", static_cast<float>(finite(constants.largest_acceleration)));
  Pass& pass = now_->step;
  const auto set = [&](const char* name, double value) { pass.set(name, static_cast<float>(value)); };
  set("dt", constants.dt);
  set("inverse_dt", 1.0 / constants.dt);
  set("damping_factor", constants.damping_factor);
  set("runaway_speed", finite(constants.runaway_speed));
  set("speed_at_rest", constants.speed_at_rest);
  set("acceleration_at_rest", constants.acceleration_at_rest);
}

void FragmentPasses::evaluate(const FragmentState& state) {
  for (Drawing& drawing : before_) {
    drawing.pass.input("displacement", state.displacement());
    drawing.pass.draw(drawing.target);
  }
}

void FragmentPasses::step(const FragmentState& state, int batch_step, bool measuring) {
  evaluate(state);
  if (four_) {
    Pass& reaction = now_->reaction;
    reaction.input("displacement", state.displacement());
    reaction.set_rows(net_, tables_->kind().particles);
    reaction.set("instant", batch_step - 1);
    reaction.draw(net_target_);
  }
  Pass& step = now_->step;
  step.input("displacement", state.displacement());
  step.input("velocity", state.velocity());
  step.set_rows(state.displacement(), tables_->kind().particles);
  step.set("instant", batch_step - 1);
  step.set("batch_step", batch_step);
  step.set("gravity", loads_->gravity(static_cast<std::size_t>(batch_step - 1)));
  step.draw(state.next(measuring));
}

const Texture& FragmentPasses::attractors(const FragmentState& state) {
  if (!showing_) {
    shown_ = Texture::target(tables_->kind().particles, TexelFormat::rgba32f, "attractors");
    shown_target_ = Framebuffer({{&shown_}});
    showing_.emplace(*library_, gathering({}, "shown_attractor_pass.glsl"));
    tables_->bind(*showing_);
    bind_terms(*showing_);
    showing_->set_rows(shown_, tables_->kind().particles);
  }
  evaluate(state);
  showing_->input("displacement", state.displacement());
  showing_->draw(shown_target_);
  return shown_;
}

}  // namespace phymul::gl
