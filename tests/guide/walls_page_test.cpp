// SPDX-License-Identifier: MIT
//
// What docs/guide/walls.md and fluids.md show, built and run.
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

TEST(GuideWalls, ASheetIsCutInTwo) {
  phymul::Surface surface;
  surface.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.05, 0}, {0, 0.05, 0}};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  const phymul::Material wall{.young = 50e3, .poisson = 0.45, .density = 1050, .thickness = 3e-3};
  const phymul::Model model = phymul::make_wall(surface, {.spacing = 10e-3, .material = wall});

  phymul::Simulation sim(with_spare_particles(model, 60), {.damping = {.rate = 10}});

  sim.cut(phymul::cut_plane({0.05, 0.0, 0.0}, {1.0, 0.2, 0.0}));

  EXPECT_EQ(connected_bodies(sim.model()).size(), 2u);
}

TEST(GuideWalls, CapsuleHoldsALiver) {
  phymul::Model liver = phymul::make_block({0.08, 0.05, 0.03}, 16, 10, 6);
  phymul::set_material(liver, {.young = 3e3, .poisson = 0.45, .density = 1050});
  phymul::add_capsule(liver, {.young = 1e6, .poisson = 0.45, .density = 1050, .thickness = 0.1e-3});

  phymul::Model bare = phymul::make_block({0.08, 0.05, 0.03}, 16, 10, 6);
  phymul::set_material(bare, {.young = 3e3, .poisson = 0.45, .density = 1050});
  double sag[2] = {0.0, 0.0};
  for (const phymul::Model* body : {&bare, &liver}) {
    phymul::Simulation sim(*body, {.damping = {.rate = 15}});
    sim.scene().fix("x0").gravity({0, 0, -0.5});
    EXPECT_TRUE(sim.advance(0.4).ok());
    sag[body == &liver] = sim.max_displacement();
  }
  EXPECT_LT(sag[1], 0.8 * sag[0]);
}

TEST(GuideFluids, BagDrains) {
  const phymul::Model ball = phymul::make_body(phymul::solid_ball({0, 0, 0}, 0.02), {.spacing = 6e-3});
  const phymul::Surface surface{.vertices = ball.rest, .triangles = phymul::surface_triangles(ball), .notes = {}};
  const phymul::Material wall{.young = 20e3, .poisson = 0.45, .density = 1050, .thickness = 1e-3};
  const phymul::Model bag = phymul::make_wall(surface, {.material = wall});
  const auto triangles = phymul::surface_triangles(bag);
  const double full = 1.1 * 4.0 / 3.0 * 3.14159 * 8e-6;
  phymul::Simulation sim(bag, {.damping = {.rate = 20}});

  phymul::VolumeConstraint bile{.triangles = triangles, .volume = full, .applied_to = {}, .name = "bile"};
  sim.scene().constrain_volume(bile);
  EXPECT_TRUE(sim.advance(0.05).ok());
  EXPECT_GT(sim.solver().fluid("bile").pressure, 10.0);

  phymul::Fluid open;
  open.conductance = 1e-9;        // m^3/(Pa s)
  open.outlet_pressure = -500.0;  // Pa
  sim.scene().set_fluid("bile", open);
  EXPECT_TRUE(sim.advance(0.5).ok());
  EXPECT_LT(sim.solver().fluid("bile").volume, full - 2.5e-7);
}

TEST(GuideFluids, BagEmptiesIntoAnother) {
  const phymul::Model ball = phymul::make_body(phymul::solid_ball({0, 0, 0}, 0.02), {.spacing = 6e-3});
  const phymul::Surface surface{.vertices = ball.rest, .triangles = phymul::surface_triangles(ball), .notes = {}};
  const phymul::Material wall{.young = 20e3, .poisson = 0.45, .density = 1050, .thickness = 1e-3};
  const phymul::Model bag = phymul::make_wall(surface, {.material = wall}), other = moved(bag, {0.06, 0, 0});
  const phymul::NamedBody bodies[] = {{"gallbladder", &bag}, {"gut", &other}};
  phymul::Simulation sim(phymul::merge_models(bodies), {.damping = {.rate = 20}});
  const double full = 1.2 * 4.0 / 3.0 * 3.14159 * 8e-6;
  phymul::VolumeConstraint bile{.triangles = {}, .volume = full, .applied_to = {}, .name = "bile"}, chyme = bile;
  chyme.name = "chyme";
  chyme.volume = full / 1.2;
  for (const auto& t : phymul::surface_triangles(sim.model())) {
    (sim.model().rest[t[0]].x() < 0.03 ? bile : chyme).triangles.push_back(t);
  }

  sim.scene().constrain_volume(bile).constrain_volume(chyme);

  phymul::Fluid duct;
  duct.conductance = 1e-7;  // m^3/(Pa s)
  duct.opens_into = "chyme";
  sim.scene().set_fluid("bile", duct);

  EXPECT_TRUE(sim.advance(1.0).ok());
  const phymul::FluidState left = sim.solver().fluid("bile"), filled = sim.solver().fluid("chyme");
  EXPECT_NEAR(left.pressure, filled.pressure, 0.01 * filled.pressure);
  EXPECT_EQ(left.volume + filled.volume, full + full / 1.2);
}

}  // namespace
