// SPDX-License-Identifier: MIT
#include "surface_passes.h"

namespace phymul::gl {

SurfacePasses::SurfacePasses(const Compile& compiled)
    : start_(compiled({"tools/surface_start_pass.glsl"}, "SURFACE_START")),
      load_(compiled({"tools/surface_law.glsl", "tools/surface_load_pass.glsl"}, "SURFACE_LOAD")),
      gather_(compiled({"tools/surface_gather_pass.glsl"}, "SURFACE_GATHER")),
      press_(compiled({"tools/surface_law.glsl"}, "SURFACE_PRESS")),
      push_(compiled({"tools/surface_push_pass.glsl"}, "SURFACE_PUSH")),
      end_(compiled({"tools/surface_end_pass.glsl"}, "SURFACE_END")) {}

void SurfacePasses::act(const ComputeSurfaces& surfaces, int tool, Index particles, const Step& step) {
  const bool placed = surfaces.was_placed(tool, step.number - 1);
  for_each([&](Kernel& kernel) {
    kernel.set("acting_tool", tool);
    kernel.set("first_law", surfaces.first_law(tool));
    kernel.set("round_shifts", placed ? 1 : 0);
    kernel.set("pair", step.pair);
    kernel.set("number", step.number);
    kernel.set("measuring", step.measuring ? 1 : 0);
  });
  const auto by_particle = [&](Kernel& kernel) { kernel.dispatch(kernel.groups_for(particles)); };
  const auto by_patch = [&](Kernel& kernel) { kernel.dispatch(kernel.groups_for(surfaces.patches())); };
  by_particle(start_);
  by_patch(load_);
  by_particle(gather_);
  for (int round = 0; round < cpu::rounds_of_surface(placed); ++round) {
    by_patch(press_);
    by_particle(push_);
  }
  by_particle(end_);
}

}  // namespace phymul::gl
