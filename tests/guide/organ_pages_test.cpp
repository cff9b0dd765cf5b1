// SPDX-License-Identifier: MIT
//
// The code of docs/guide/organs.md, planning.md and formats.md that no example has: check.pages finds each block of
// these pages here or there.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "guide/scratch_folder.h"

namespace {

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

}  // namespace
