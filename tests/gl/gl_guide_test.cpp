// SPDX-License-Identifier: MIT
//
// The code of docs/guide/pictures.md: check.pages finds each block of the page here.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>

#include "support/every_backend.h"

namespace {

phymul::Simulation pressed_block() {
  phymul::Simulation sim(phymul::make_block({0.04, 0.04, 0.02}, 4, 4, 2),
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1000}, .backend = "cpu"});
  sim.scene().fix("z0").gravity({0, 0, -9.81});
  sim.advance(0.02);
  return sim;
}

/// Pixels that are not white.
auto drawn(const phymul::Image& image) {
  return std::count_if(image.rgba.begin(), image.rgba.end(), [](unsigned char value) { return value < 255; });
}

TEST(GlGuidePictures, DrawTheBody) {
  PHYMUL_SKIP_OR_FAIL(phymul::test::why_not_here("gl"));
  phymul::Simulation sim = pressed_block();

  const auto display = phymul::make_display(sim.solver());  // on a GL backend: from the solver's own texture
  const phymul::Camera camera = phymul::framing(sim.model().rest, {0.5, -1.0, 0.4}, 4.0 / 3.0);
  const phymul::Image image = display->render(camera, {.links = true, .full_scale = 0.005}, 800, 600);

  EXPECT_GT(drawn(image), 10'000);
}

TEST(GlGuidePictures, DrawASkin) {
  PHYMUL_SKIP_OR_FAIL(phymul::test::why_not_here("gl"));
  phymul::Simulation sim = pressed_block();
  const phymul::VecList vertices = sim.model().rest;
  const auto triangles = phymul::surface_triangles(sim.model());

  const phymul::Skin skin(sim.model(), vertices);  // once; an Error names the first vertex that is far outside
  const auto display = phymul::make_display(sim.solver(), skin, triangles);  // draws the skin instead of the body
  phymul::VecList places, normals;
  skin.deform(sim.solver().read().position, places);  // or for a renderer of your own, in each frame
  phymul::surface_normals(triangles, places, normals);

  EXPECT_EQ(places.size(), normals.size());
  const phymul::Camera camera = phymul::framing(sim.model().rest, {0.5, -1.0, 0.4}, 4.0 / 3.0);
  EXPECT_GT(drawn(display->render(camera, {}, 400, 300)), 1'000);
}

}  // namespace
