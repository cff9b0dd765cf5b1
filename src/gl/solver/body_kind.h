// SPDX-License-Identifier: MIT
//
// What a body holds, as far as shaders differ for it, and which of glsl/ they are made of.
#pragma once

#include <phymul/topology.h>

#include <initializer_list>

#include "device/float_tables.h"
#include "gl/context/context_info.h"
#include "gl/objects/shader_source.h"
#include "load_table.h"

namespace phymul::gl {

struct BodyKind {
  TopologyOptions options;
  int dimension = 3;
  int law_texels = 1;
  Index particles = 0, bases = 0, volumes = 0, walls = 0, domains = 0;
  bool attractors = false;  ///< particles have a force F_i of their own: any reaction but the conservative
  bool base_terms = false;  ///< bases are evaluated a row each: averaged, conservative
  bool springs = false;
  bool several_domains = false;  ///< some particles have more than one
  bool enumerated = false;
  KeptStrains kept;  ///< by domains, where the material dissipates

  explicit BodyKind(const FloatTables& tables);
  bool conservative() const { return base_terms && !attractors; }
  bool dissipates() const { return kept.count() > 0; }
  int strain_texels() const { return 2 * static_cast<int>(kept.count()); }  ///< per domain
};

using ShaderFiles = std::vector<std::string>;
ShaderFiles joined(std::initializer_list<ShaderFiles> parts);

// Kernels and passes, in the order in which they need each other.
const ShaderFiles& base_kernel();
ShaderFiles attractor_files(const BodyKind& kind);
const ShaderFiles& volume_kernel();
const ShaderFiles& wall_kernel();
ShaderFiles domain_files(const BodyKind& kind);  ///< what stresses of domains need, up to dissipation.glsl
const ShaderFiles& gathering_files();            ///< up to net_force.glsl
const ShaderFiles& tool_files();                 ///< up to touch_tools.glsl; needs net_force.glsl

ShaderFiles joint_files(bool on_tools);  ///< up to joint_law.glsl; on_tools: some joint ends at a tool

/// The kernels' macros.
void define_kernels(const BodyKind& kind, ShaderRequest& request);
/// What the body and the loads need of net_force.glsl.
void define_gathering(const BodyKind& kind, const LoadKind& loads, ShaderRequest& request);
/// What tool_tables.glsl is read by.
void define_tool_rows(ShaderRequest& request);
void define_joints(bool on_tools, ShaderRequest& request);
/// What a pass that tools act in is asked for; `grids`: some are distance grids.
void define_tools(bool grids, ShaderRequest& request);

/// Throws Error where a particle would take more turns than ContextInfo::loop_turns: forces would be missing.
void require_turns(const ContextInfo& info, LoopTurns turns);

}  // namespace phymul::gl
