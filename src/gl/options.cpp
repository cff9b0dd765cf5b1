// SPDX-License-Identifier: MIT
#include "gl/options.h"

#include <phymul/error.h>

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

namespace phymul::gl {
namespace {

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

bool can_enumerate(const TopologyTextures& topology) {
  const TopologyOptions& o = topology.options;
  const bool thesis =
      o.reaction == Reaction::full || o.reaction == Reaction::shared || o.reaction == Reaction::barycentric;
  return topology.dimension == 3 && o.law == Law::shape_memory && o.bases == BaseSelection::all && thesis &&
         topology.base_count > 0;
}

/// Bytes that the two layouts do not share; see FloatTables.
bool enumerated_is_smaller(const TopologyTextures& topology) {
  double triples = 0.0;
  for (const IndexTexel& at : topology.index) {
    const double n = at.neighbour_count;
    triples += n * (n - 1.0) * (n - 2.0) / 6.0;
  }
  const double table = sizeof(Int4) + 2 * sizeof(Float4) + sizeof(Int2);
  return triples * sizeof(float) + topology.neighbour_count * (sizeof(Float4) - sizeof(float)) <
         topology.base_count * table;
}

GlCompute compute_of(std::string_view name) {
  constexpr std::array names{std::pair{"auto", GlCompute::automatic}, std::pair{"store", GlCompute::store},
                             std::pair{"recompute", GlCompute::recompute},
                             std::pair{"workgroup", GlCompute::workgroup}};
  for (const auto& [known, value] : names) {
    if (name == known) return value;
  }
  throw Error("PHYMUL_GL_COMPUTE: expected auto, store, recompute or workgroup, got \"" + std::string(name) + "\"");
}

}  // namespace

GlOptions with_environment(GlOptions options) {
  const GlOptions defaults;
  if (const std::string_view passes = environment("PHYMUL_GL_PASSES");
      options.passes == defaults.passes && !passes.empty()) {
    if (passes != "2" && passes != "4") {
      throw Error("PHYMUL_GL_PASSES: expected 2 or 4, got \"" + std::string(passes) + "\"");
    }
    options.passes = passes == "4" ? 4 : 2;
  }
  if (options.passes != 2 && options.passes != 4) {
    throw Error("GlOptions::passes: expected 2 or 4, got " + std::to_string(options.passes));
  }
  if (const std::string_view compute = environment("PHYMUL_GL_COMPUTE");
      options.compute == defaults.compute && !compute.empty()) {
    options.compute = compute_of(compute);
  }
  if (options.shader_folder.empty()) options.shader_folder = environment("PHYMUL_GLSL");
  return options;
}

FloatLayout choose_layout(BaseLayout wish, const TopologyTextures& topology) {
  if (wish == BaseLayout::enumerated) return FloatLayout::enumerated;  // pack_floats refuses what cannot be
  const bool automatic = wish == BaseLayout::automatic;
  return automatic && can_enumerate(topology) && enumerated_is_smaller(topology) ? FloatLayout::enumerated
                                                                                 : FloatLayout::table;
}

}  // namespace phymul::gl
