// SPDX-License-Identifier: MIT
#include "body_kind.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <string>

#include "device/float_domains.h"
#include "device/float_tools.h"
#include "interaction/distance_to_shape.h"
#include "topology/energies.h"

namespace phymul::gl {

LoadTable::LoadTable(const Scene& scene, int instants, const std::vector<Index>& materials)
    : scene_(&scene), materials_(&materials), modes_(scene.modes()) {
  kind_ = {.forces = !modes_.force_offset.empty(),
           .fixed = !modes_.fixed.empty(),
           .scaled = !scene.stiffness_factors().empty() && !materials.empty(),
           .joints = !scene.joints().empty()};
  row_.resize(static_cast<std::size_t>(modes_.count));
  gravity_.resize(static_cast<std::size_t>(instants));
  if (kind_.any()) values_.resize(gravity_.size() * row_.size());
  if (kind_.scaled) factors_.resize(materials.size());
}

std::vector<Float4> LoadTable::parts() const {
  std::vector<Float4> parts;
  for (const auto* list : {&modes_.force, &modes_.target}) {
    for (const LoadModes::Part& part : *list) parts.push_back(float4(part.vector, static_cast<float>(part.mode)));
  }
  return parts;
}

std::vector<Int4> LoadTable::index() const {
  const auto targets = static_cast<Index>(modes_.force.size());
  std::vector<Int4> index(scene_->model().rest.size(), Int4{});
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (kind_.forces) {
      index[i][0] = modes_.force_offset[i];
      index[i][1] = modes_.force_offset[i + 1];
    }
    if (kind_.fixed) {
      index[i][2] = targets + modes_.target_offset[i];
      index[i][3] = (modes_.target_offset[i + 1] - modes_.target_offset[i]) * 8 + modes_.fixed[i];
    }
  }
  return index;
}

void LoadTable::evaluate(const std::vector<double>& instants) {
  float* out = values_.data();
  for (std::size_t at = 0; at < instants.size(); ++at) {
    scene_->mode_values(instants[at], row_);
    Vec3 gravity = modes_.gravity;
    for (const LoadModes::Part& part : modes_.acceleration) gravity += row_[part.mode] * part.vector;
    gravity_[at] = float4(gravity);
    if (kind_.any())
      out = std::transform(row_.begin(), row_.end(), out, [](double v) { return static_cast<float>(v); });
  }
}

bool LoadTable::scale() {
  const std::vector<double>& now = scene_->stiffness_factors();
  if (!kind_.scaled || now == of_materials_) return false;
  of_materials_ = now;
  spread_factors(*materials_, now, factors_);
  return true;
}

BodyKind::BodyKind(const FloatTables& tables)
    : options(tables.options),
      dimension(tables.dimension),
      law_texels(tables.domains.law_texels),
      particles(tables.particle_count),
      bases(tables.base_count),
      volumes(tables.volume_count),
      walls(tables.walls.count()),
      domains(tables.domains.count()),
      attractors(tables.has_attractors()),
      base_terms(!tables.base.empty() &&
                 (tables.options.reaction == Reaction::averaged || tables.options.reaction == Reaction::conservative)),
      springs(!tables.spring.empty()),
      several_domains(!tables.domains.owner.empty()),
      enumerated(tables.layout == FloatLayout::enumerated),
      kept(tables.domains.kept) {}

ShaderFiles joined(std::initializer_list<ShaderFiles> parts) {
  ShaderFiles all;
  for (const ShaderFiles& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const ShaderFiles& base_kernel() {
  static const ShaderFiles files{"kernels/base.glsl"};
  return files;
}

ShaderFiles attractor_files(const BodyKind& kind) {
  return {kind.enumerated ? "kernels/attractor_pull_enumerated.glsl" : "kernels/attractor_pull.glsl",
          "step/attractor_pass.glsl"};
}

const ShaderFiles& volume_kernel() {
  static const ShaderFiles files{"kernels/columns.glsl", "kernels/volume.glsl"};
  return files;
}

const ShaderFiles& wall_kernel() {
  static const ShaderFiles files{"kernels/wall.glsl"};
  return files;
}

ShaderFiles domain_files(const BodyKind& kind) {
  ShaderFiles files{"kernels/columns.glsl", "kernels/volume.glsl", "kernels/neo_hookean.glsl",
                    std::string("kernels/energy_") + kind_of(kind.options.strain_energy).name + ".glsl",
                    "step/domain_gradient.glsl"};
  if (kind.dissipates()) files.insert(files.end(), {"kernels/green_strain.glsl", "step/dissipation.glsl"});
  return files;
}

const ShaderFiles& gathering_files() {
  static const ShaderFiles files{"kernels/spring.glsl", "kernels/integrate.glsl", "step/force_of.glsl",
                                 "step/terms_of.glsl", "step/net_force.glsl"};
  return files;
}

const ShaderFiles& tool_files() {
  static const ShaderFiles files{"tools/tool_tables.glsl", "tools/distance_to_shape.glsl", "tools/contact_tool.glsl",
                                 "tools/touch_tools.glsl"};
  return files;
}

ShaderFiles joint_files(bool on_tools) {
  ShaderFiles files{"kernels/spring.glsl", "kernels/joint.glsl", "joints/joint_tables.glsl"};
  if (on_tools) files.emplace_back("tools/tool_tables.glsl");
  files.emplace_back("joints/joint_law.glsl");
  return files;
}

void define_joints(bool on_tools, ShaderRequest& request) {
  if (!on_tools) return;
  request.defines.emplace_back("JOINT_TOOLS", 1);
  define_tool_rows(request);
}

void define_kernels(const BodyKind& kind, ShaderRequest& request) {
  request.defines.emplace_back("DIMENSION", kind.dimension);
  if (kind.options.volume_law == VolumeLaw::bounded) request.defines.emplace_back("BOUNDED_VOLUME", 1);
  request.defines.emplace_back("LAW_TEXELS", kind.law_texels);
  if (kind.walls > 0) request.defines.emplace_back("WALL_TEXELS", FloatWalls::law_texels);
  if (kind.several_domains) request.defines.emplace_back("SEVERAL_DOMAINS", 1);
  if (!kind.dissipates()) return;
  request.defines.emplace_back("DISSIPATES", 1);
  request.defines.emplace_back("STRAIN_TEXELS", kind.strain_texels());
  if (kind.kept.rate) request.defines.emplace_back("STRAIN_RATE", 1);
  if (kind.kept.branch) request.defines.emplace_back("STRAIN_BRANCH", 1);
}

void define_gathering(const BodyKind& kind, const LoadKind& loads, ShaderRequest& request) {
  const auto define = [&](const char* name, bool wanted) {
    if (wanted) request.defines.emplace_back(name, 1);
  };
  define("ATTRACTORS", kind.attractors);
  define("SHARES", kind.attractors && !kind.base_terms);
  define("BASE_TERMS", kind.base_terms);
  define("CONSERVATIVE", kind.conservative());
  define("VOLUMES", kind.volumes > 0);
  define("WALLS", kind.walls > 0);
  define("DOMAINS", kind.domains > 0);
  define("SPRINGS", kind.springs);
  define("FORCES", loads.forces);
  define("JOINTS", loads.joints);
  define("FIXED", loads.fixed);
}

void define_tool_rows(ShaderRequest& request) {
  request.defines.emplace_back("TOOL_LAW_ROWS", static_cast<int>(FloatTools::law_rows));
  request.defines.emplace_back("TOOL_FRAME_ROWS", static_cast<int>(FloatTools::frame_rows));
  request.defines.emplace_back("TOOL_GRID_UNIT", static_cast<int>(FloatTools::grid_unit));
}

void define_tools(bool grids, ShaderRequest& request) {
  constexpr std::array shapes{std::pair{"SHAPE_SPHERE", ShapeKind::sphere},
                              std::pair{"SHAPE_CAPSULE", ShapeKind::capsule},
                              std::pair{"SHAPE_HALF_SPACE", ShapeKind::half_space},
                              std::pair{"SHAPE_BOX", ShapeKind::box}, std::pair{"SHAPE_GRID", ShapeKind::grid}};
  request.defines.emplace_back("TOOLS", 1);
  if (grids) request.defines.emplace_back("TOOL_GRIDS", 1);
  for (const auto& [name, kind] : shapes) request.defines.emplace_back(name, static_cast<int>(kind));
  define_tool_rows(request);
}

void require_turns(const ContextInfo& info, LoopTurns turns) {
  const std::int64_t all = turns.own + turns.gathered;
  if (all <= info.loop_turns) return;
  throw Error(ErrorCode::not_supported, "expected at most " + std::to_string(info.loop_turns) +
                                            " turns of the loops of a shader, which is where " + info.renderer +
                                            " breaks off, got up to " + std::to_string(all) +
                                            " for a particle of this body; use fewer bases or another backend");
}

}  // namespace phymul::gl
