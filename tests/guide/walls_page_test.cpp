// SPDX-License-Identifier: MIT
//
// What docs/guide/walls.md shows, built and run.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

namespace {

TEST(GuideWalls, SheetOnAClampedEdgeSags) {
  phymul::Surface surface;
  surface.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.05, 0}, {0, 0.05, 0}};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};

  const phymul::Material wall{.young = 50e3, .poisson = 0.45, .density = 1050, .thickness = 3e-3};
  phymul::Model model = phymul::make_wall(surface, {.spacing = 10e-3, .material = wall});

  phymul::clamp_edges(model, [](const phymul::Vec3& place) { return place.x() < 1e-6; });

  phymul::Simulation sim(model, {.damping = {.rate = 10}});
  sim.scene()
      .fix(model.particles_in([](const phymul::Vec3& place) { return place.x() < 1e-6; }))
      .gravity({0, 0, -0.03});
  const phymul::RestResult rest = sim.run_to_rest();
  EXPECT_TRUE(rest.converged()) << rest.message();
  // A cantilever under its weight: q L^4 / (8 E I) = 12 rho g L^4 / (8 E t^2), less where it is a plate.
  const double beam = 12.0 * 1050.0 * 0.03 * 1e-4 / (8.0 * 50e3 * 9e-6);
  EXPECT_NEAR(sim.max_displacement() / beam, 0.8, 0.2);
}

}  // namespace
