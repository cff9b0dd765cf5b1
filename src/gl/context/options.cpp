// SPDX-License-Identifier: MIT
#include "options.h"

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

GlCompute compute_of(std::string_view name) {
  constexpr std::array names{std::pair{"auto", GlCompute::automatic}, std::pair{"store", GlCompute::store},
                             std::pair{"workgroup", GlCompute::workgroup}};
  for (const auto& [known, value] : names) {
    if (name == known) return value;
  }
  throw Error("PHYMUL_GL_COMPUTE: expected auto, store or workgroup, got \"" + std::string(name) + "\"");
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

}  // namespace phymul::gl
