// SPDX-License-Identifier: MIT
//
// The code of docs/guide/bodies.md, organs.md, planning.md, formats.md, walls.md and fluids.md that no example has:
// check.pages finds each block of these pages here or there.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "support/message_of.h"
#include "support/text_file.h"

namespace {

TEST(GuideBodies, ReadsAMesh) {
  const ScratchFolder folder;
  std::filesystem::copy(PHYMUL_TEST_DATA "/mesh/mixed_41.msh", "liver.msh");

  phymul::Model liver = phymul::read_mesh("liver.msh", {.length_unit = 1e-3});  // file in mm
  for (const std::string& note : liver.notes) std::puts(note.c_str());          // what was found and corrected

  EXPECT_GT(liver.particle_count(), 0);
}

TEST(GuideBodies, TakesPointsWithoutCells) {
  const phymul::VecList points = phymul::make_block({0.04, 0.04, 0.04}, 5, 5, 5).rest;

  phymul::Model model;
  model.rest = points;                    // of the surface too: the body is what the points span
  model.mass.assign(points.size(), 1.0);  // set_material overwrites it
  model.stiffness.assign(points.size(), 1.0);
  model.neighbours = phymul::nearest_neighbours(points, 20);
  phymul::set_material(model, {.young = 6e3, .poisson = 0.45, .density = 1060});

  phymul::Simulation sim(model);
  sim.scene().gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.1).ok());
  EXPECT_NEAR(sim.max_displacement(), 0.5 * 9.81 * 0.1 * 0.1, 1e-3);  // it falls
}

TEST(GuideBodies, MakesGroupsAndSetsMaterials) {
  phymul::Model model = phymul::make_block({0.06, 0.06, 0.06}, 12, 12, 12);
  const phymul::Vec3 centre(0.03, 0.03, 0.03);

  const auto tumour = [&](const phymul::Vec3& at) { return (at - centre).norm() < 0.01; };
  model.add_group("tumour", model.particles_in(tumour));

  phymul::set_material(model, {.young = 6e3, .poisson = 0.45, .density = 1060});            // Pa, 1, kg/m^3
  phymul::set_material(model, {.young = 3e4, .poisson = 0.45, .density = 1060}, "tumour");  // cells of the group
  const double reached = phymul::set_material(model, {.young = 3e4, .poisson = 0.45, .density = 1060}, tumour);

  EXPECT_NEAR(reached, 4.0 / 3.0 * std::numbers::pi * 1e-6, 1e-6);  // the ball's
  EXPECT_EQ(model.materials.size(), 2U);
}

TEST(GuideBodies, FitsAMaterialToTests) {
  phymul::Model model = phymul::make_block({0.02, 0.02, 0.02}, 2, 2, 2);

  using enum phymul::StrainTest;
  const std::vector<phymul::TestPoint> measured{{uniaxial, 0.9, -1148}, {uniaxial, 0.95, -350},  // stretch, Pa
                                                {uniaxial, 1.05, 149},  {uniaxial, 1.1, 415},
                                                {shear, 0.1, 141},      {shear, 0.2, 544}};  // amount, Pa
  const phymul::MaterialFit fit = phymul::fit_material(measured, {.poisson = 0.49, .density = 1040});
  phymul::set_material(model, fit.material);  // fit.largest_error: relative

  EXPECT_LT(fit.largest_error, 0.15);
}

TEST(GuideBodies, StiffensWhileItRuns) {
  phymul::Model model = phymul::make_block({0.04, 0.04, 0.04}, 4, 4, 4);
  phymul::set_material(model, {.young = 6e3, .poisson = 0.45, .density = 1060});
  const auto half = [](const phymul::Vec3& at) { return at.z() < 0.02; };
  phymul::set_material(model, {.young = 3e4, .poisson = 0.45, .density = 1060}, half);
  phymul::Simulation sim(model, {.backend = "cpu"});
  const double before = sim.solver().stable_step();

  phymul::Material tumour{.young = 3e4, .poisson = 0.45, .density = 1060};
  sim.scene().scale_stiffness(1.2);          // all materials
  sim.scene().scale_stiffness(tumour, 0.5);  // one, as set_material got it

  EXPECT_NE(sim.solver().stable_step(), before);
  EXPECT_TRUE(sim.advance(0.01).ok());
}

TEST(GuideBodies, HasSprings) {
  const double E = 10e3, h = 0.01;                                              // Pa; m, the lattice's spacing
  phymul::Model block = phymul::make_block({0.1, 0.1, 0.1}, 10, 10, 10, 18);    // 18 neighbours
  phymul::set_material(block, {.young = E, .poisson = 0.25, .density = 1000});  // for the masses
  block.materials.clear();
  for (phymul::Cell& cell : block.cells) cell.material = -1;
  block.stiffness.assign(block.rest.size(), 0.4 * E * h);  // N/m
  phymul::Simulation sim(block, {.topology = {.law = phymul::Law::springs}});
  sim.scene().fix("z0").gravity({0, 0, -9.81});

  ASSERT_TRUE(sim.advance(0.05).ok());
  EXPECT_GT(sim.max_displacement(), 1e-4);
}

TEST(GuideBodies, PutsTwoInOneScene) {
  const phymul::Model organ = phymul::make_block({0.04, 0.04, 0.02}, 4, 4, 2);  // has the group z0
  const phymul::Material soft{.young = 8e3, .poisson = 0.4, .density = 1000};
  const phymul::Material stiff{.young = 40e3, .poisson = 0.4, .density = 1000};
  phymul::Simulation sim({{"liver", organ, stiff}, {"gallbladder", phymul::moved(organ, {0, 0, 0.022}), soft}});
  sim.scene().fix("liver/z0").contacts({.friction = 0.4});

  const phymul::StepLimit limit = phymul::describe_limit(sim.model(), sim.solver().topology());
  std::puts(limit.message().c_str());  // "The stable step of 0.000408 s is set by cell 155, at (0.0138, ...) m, ..."

  EXPECT_TRUE(phymul::says(limit.message(), "is set by"));
  EXPECT_TRUE(sim.advance(0.01).ok());
}

/// Of a ball of 4 cm, as a file would have it.
phymul::Surface ball() {
  const phymul::Model filled = phymul::make_body(phymul::solid_ball({0, 0, 0}, 0.04), {.spacing = 0.008});
  return {.vertices = filled.rest, .triangles = phymul::surface_triangles(filled), .notes = {}};
}

TEST(GuideOrgans, AreFineWhereItMattersAndShowTheirSurface) {
  const phymul::Surface surface = ball();
  const phymul::Vec3 target(0, 0, 0.03);

  const auto field = phymul::fine_near(target, 0.012, 0.004, 0.016);  // radius, spacing within it and far from it, m
  phymul::Model organ = phymul::make_body(surface, {.spacing = 0.016, .spacing_at = field});

  const auto near = organ.particles_in([&](const phymul::Vec3& x) { return (x - target).norm() < 0.012; });
  const auto opposite = organ.particles_in([&](const phymul::Vec3& x) { return (x + target).norm() < 0.012; });
  EXPECT_GT(near.size(), 4 * opposite.size());

  phymul::Simulation sim(organ, {.material = {.young = 5e3, .poisson = 0.45, .density = 1050}, .backend = "cpu"});
  sim.scene().gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.05).ok());

  const phymul::Skin skin(organ, surface.vertices);
  const phymul::VecList vertices = skin.deform(sim.solver().read().position);  // of surface.triangles, in each frame

  ASSERT_EQ(vertices.size(), surface.vertices.size());
  EXPECT_NEAR(surface.vertices[0].z() - vertices[0].z(), 0.5 * 9.81 * 0.05 * 0.05, 1e-3);
}

TEST(GuideOrgans, AreHeldByTheirSurface) {
  const phymul::Surface surface = ball();
  phymul::Simulation sim(phymul::make_body(surface, {.spacing = 0.008}),
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1000}, .backend = "cpu"});
  sim.scene().gravity({0, 0, -9.81});

  const auto below = [](const phymul::Vec3& place) { return place.z() < -0.0254; };
  sim.scene().hold(phymul::sample_surface(surface, 0.002, below));  // points 2 mm apart: a third of the spacing

  ASSERT_TRUE(sim.run_to_rest().converged());
  const phymul::Vec3 force = sim.report_of(sim.scene().joint("joint 1")).force;
  const double weight = 9.81 * 1000 * 4.0 / 3.0 * 3.14159 * 0.04 * 0.04 * 0.04;
  EXPECT_NEAR(std::abs(force.z()), weight, 0.02 * weight);
}

TEST(GuideOrgans, ComeFromSolids) {
  const phymul::Solid lobe = phymul::solid_ellipsoid({0, 0, 0}, {0.06, 0.04, 0.03});
  const phymul::Solid vessel = phymul::solid_capsule({-0.1, 0, 0}, {0.1, 0, 0}, 0.008);
  const phymul::Model body = phymul::make_body(phymul::solid_difference(lobe, vessel), {.spacing = 0.004});

  EXPECT_GT(body.particle_count(), 1000);
  EXPECT_TRUE(body.particles_in([](const phymul::Vec3& x) { return std::hypot(x.y(), x.z()) < 0.006; }).empty());
}

TEST(GuidePlanning, TakesABuilder) {
  const phymul::Material soft{.young = 5e3, .poisson = 0.45, .density = 1000};
  const auto builder = [=](const phymul::PlanCandidate& candidate) {
    const int n = std::max(1, static_cast<int>(std::lround(0.05 / candidate.spacing)));
    phymul::Simulation sim(phymul::make_block({0.2, 0.05, 0.05}, 4 * n, n, n), candidate.options({.material = soft}));
    sim.scene().fix("x0").gravity({0, 0, -1.0});
    return sim;
  };
  const phymul::Plan plan = phymul::plan(builder, {.max_error = 0.03, .rate = 1000});

  EXPECT_FALSE(plan.trials.empty());
  EXPECT_FALSE(plan.report().empty());
}

TEST(GuideFormats, ReadAndWriteFiles) {
  const ScratchFolder folder;
  std::filesystem::copy(PHYMUL_SAMPLE_DATA "/cylinder_275.pml", "liver.pml");
  std::filesystem::copy(PHYMUL_SAMPLE_DATA "/cylinder_275_pull.lml", "pull.lml");

  phymul::PmlOptions options;
  options.length_unit = 1e-3;  // the file has no unit; by convention millimetres
  phymul::Model model = phymul::read_pml("liver.pml", options);
  for (const std::string& note : model.notes) std::puts(note.c_str());

  ASSERT_EQ(model.particle_count(), 275);
  phymul::Scene scene(model);

  std::vector<std::string> notes;
  scene.add(phymul::read_lml("pull.lml", model, &notes));

  EXPECT_FALSE(scene.loads().empty());
  phymul::Simulation sim(model);

  sim.save("run.state");  // save_state(solver, path)
  sim.load("run.state");  // load_state(solver, path)

  sim.record();      // from now on
  sim.advance(0.1);  // the application changes the scene and steps as it likes
  phymul::save_recording(sim.recording(), "session.rec");
  sim.replay(phymul::read_recording("session.rec"));

  EXPECT_NEAR(sim.time(), 0.1, 1e-9);
}

TEST(GuideFormats, BodiesOfAPmlScene) {
  const ScratchFolder folder;
  std::filesystem::copy(PHYMUL_TEST_DATA "/hanging_bodies.pml", "scene.pml");

  phymul::Simulation sim(phymul::read_pml("scene.pml"));
  for (const std::string& done : phymul::add_body_types(sim.scene())) std::puts(done.c_str());

  EXPECT_EQ(sim.scene().joints().size(), 3u);
}

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
