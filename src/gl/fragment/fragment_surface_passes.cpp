// SPDX-License-Identifier: MIT
#include "fragment_surface_passes.h"

namespace phymul::gl {

FragmentSurfacePasses::FragmentSurfacePasses(const Compile& compiled)
    : start_(compiled({"tools/surface_start_pass.glsl"})),
      load_(compiled({"tools/surface_law.glsl", "tools/surface_load_pass.glsl"})),
      gather_(compiled({"tools/surface_gather_pass.glsl"})),
      press_(compiled({"tools/surface_law.glsl", "tools/surface_press_pass.glsl"})),
      push_(compiled({"tools/surface_push_pass.glsl"})),
      end_(compiled({"tools/surface_end_pass.glsl"})),
      particles_(compiled({"tools/press_pass.glsl"})) {}

void FragmentSurfacePasses::bind(const FragmentSurfaces& surfaces) {
  for_each([&](Pass& pass) { surfaces.bind(pass); });
  const Texture& by_particle = surfaces.first_end();
  for (Pass* const pass : {&start_, &gather_, &push_, &end_, &particles_}) {
    pass->set_rows(by_particle, surfaces.particles());
  }
  load_.set_rows(surfaces.load(), surfaces.patches());
}

void FragmentSurfacePasses::set_step(double dt) {
  for_each([dt](Pass& pass) {
    pass.set("dt", static_cast<float>(dt));
    pass.set("inverse_dt", static_cast<float>(1.0 / dt));
  });
}

void FragmentSurfacePasses::act(FragmentSurfaces& surfaces, const Texture& displacement, int batch_step) {
  for_each([&](Pass& pass) {
    pass.input("displacement", displacement);
    pass.set("instant", batch_step - 1);
  });
  for (int tool = 0; tool < surfaces.tools(); ++tool) {
    if (surfaces.is_one(tool)) {
      act_on_surfaces(surfaces, tool, batch_step);
      continue;
    }
    particles_.set("acting_tool", tool);
    surfaces.open().bind(particles_);
    particles_.draw(surfaces.next_open(tool));
  }
}

void FragmentSurfacePasses::act_on_surfaces(FragmentSurfaces& surfaces, int tool, int batch_step) {
  const bool placed = surfaces.was_placed(tool, batch_step - 1);
  for_each([&](Pass& pass) {
    pass.set("acting_tool", tool);
    pass.set("first_law", surfaces.first_law(tool));
    pass.set("round_shifts", placed ? 1 : 0);
    surfaces.open().bind(pass);
  });
  press_.set_rows(surfaces.push(), placed ? 2 * surfaces.patches() : surfaces.patches());
  start_.draw(surfaces.first_target);
  load_.draw(surfaces.load_target);
  gather_.draw(surfaces.next_corners());
  for (int round = 0; round < cpu::rounds_of_surface(placed); ++round) {
    surfaces.bind_corners(press_);
    press_.draw(surfaces.push_target);
    surfaces.bind_corners(push_);
    push_.draw(surfaces.next_corners());
  }
  surfaces.bind_corners(end_);
  end_.draw(surfaces.next_open(tool));
}

}  // namespace phymul::gl
