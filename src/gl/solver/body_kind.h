// SPDX-License-Identifier: MIT
//
// What a body holds, as far as shaders differ for it, and which of glsl/ they are made of. What a scene does to a body,
// in rows for a device: vectors per particle, which change with the scene, and a small table of the numbers they are
// multiplied by, a row per instant of a batch of steps.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/scene.h>
#include <phymul/topology.h>

#include <initializer_list>
#include <vector>

#include "device/float_tables.h"
#include "device/table_rows.h"
#include "gl/context/context_info.h"
#include "gl/objects/program.h"

namespace phymul::gl {

/// Which shaders a scene needs: one that holds nothing pays nothing.
struct LoadKind {
  bool forces = false, fixed = false;
  bool scaled = false;  ///< the stiffness of some material has a factor
  bool joints = false;
  bool any() const { return forces || fixed; }
  bool operator==(const LoadKind&) const = default;
};

class LoadTable {
 public:
  /// Room for the values of as many instants. `materials`, of the body's domains by row, must outlive it.
  LoadTable(const Scene& scene, int instants, const std::vector<Index>& materials);

  const LoadKind& kind() const { return kind_; }
  int mode_count() const { return modes_.count; }

  /// Per particle: first and end row of its force parts, first row of its target parts, their number * 8 + fixed axes.
  std::vector<Int4> index() const;
  /// Vector, number of the value it is multiplied by.
  std::vector<Float4> parts() const;

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  /// Of the instants given to evaluate(): [instants][modes]; empty where kind() has nothing.
  const std::vector<float>& values() const { return values_; }
  /// Takes over the factors of the stiffness. True where they are not those of before.
  bool scale();
  /// [domains] as scale() found them; empty where nothing is scaled.
  const std::vector<float>& factors() const { return factors_; }
  /// [instants] m/s^2: gravity and uniform accelerations.
  const std::vector<Float4>& gravity() const { return gravity_; }

 private:
  const Scene* scene_;
  const std::vector<Index>* materials_;
  LoadModes modes_;
  LoadKind kind_;
  std::vector<double> row_;  // [modes] at one instant
  std::vector<float> values_;
  std::vector<Float4> gravity_;
  std::vector<float> factors_;
  std::vector<double> of_materials_;  // that factors_ are for
};

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
