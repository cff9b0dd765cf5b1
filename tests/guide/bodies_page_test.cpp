// SPDX-License-Identifier: MIT
//
// The code of docs/guide/bodies.md: check.pages finds each block of the page here.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cstdio>
#include <filesystem>
#include <numbers>

#include "guide/scratch_folder.h"
#include "support/message_of.h"

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

}  // namespace
