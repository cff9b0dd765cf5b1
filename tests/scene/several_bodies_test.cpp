// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/topology_textures.h>

#include <sstream>

#include "interaction/contact_surface.h"
#include "scene/loose_parts.h"
#include "support/message_of.h"
#include "support/rounding_bound.h"
#include "support/run_scenes.h"

namespace phymul {
namespace {

using namespace test;

struct TwoOrgans {
  Model soft = make_block({0.03, 0.02, 0.02}, 6, 4, 4);
  Model hard = moved(make_cylinder(0.01, 0.03, 2, 8, 4), {0.1, 0, 0.02});
  TwoOrgans() {
    set_material(soft, {3e3, 0.45, 1000.0});
    set_material(hard, {60e3, 0.3, 1500.0});
  }
  Model both() const { return merged({{"soft", &soft}, {"hard", &hard}}); }
};

/// Pull, gravity and a pressure on each, by the groups of the body with a prefix.
void act(Scene& scene, const Model& body, const std::string& prefix, const char* held, const char* pulled) {
  scene.fix(prefix + held);
  scene.add(pull(body, (prefix + pulled).c_str(), {0.3, 0, 1}, {{0, 0}, {0.01, 0.002}}));
}

TEST(SeveralBodies, NamesMaterialsAndRowsAreKept) {
  const TwoOrgans organs;
  const Model both = organs.both();
  const Index first = organs.soft.particle_count();
  EXPECT_EQ(both.particle_count(), first + organs.hard.particle_count());
  EXPECT_EQ(both.group("soft").size(), organs.soft.rest.size());
  EXPECT_EQ(both.group("hard").front(), first);
  std::vector<Index> bottom = organs.hard.group("bottom");
  for (Index& i : bottom) i += first;
  EXPECT_EQ(both.group("hard/bottom"), bottom);
  ASSERT_EQ(both.materials.size(), 2u);
  EXPECT_EQ(both.materials[both.cells.back().material], organs.hard.materials[0]);
  const std::vector<ConnectedBody> found = connected_bodies(both);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].name, "soft");
  EXPECT_EQ(found[1].name, "hard");
  EXPECT_EQ(found[1].particles, both.group("hard"));
  Model as_it_is = organs.hard;
  as_it_is.most_mass_moved = 0.0;
  EXPECT_NE(as_it_is, organs.hard);
  EXPECT_EQ(merge_models(std::vector<NamedBody>{{"soft", &organs.soft}, {"hard", &as_it_is}}).most_mass_moved, 0.0);
}

/// A merged model is a PML file as good as any, and its loads go by the prefixed names.
TEST(SeveralBodies, PmlAndLmlCarryThem) {
  const Model both = TwoOrgans().both();
  std::ostringstream out;
  write_pml(both, out);
  const Model again = read_pml_text(out.str(), "both.pml");
  EXPECT_TRUE(again == both);
  const std::vector<Load> loads = read_lml_text(
      "<loads><load type='Force'><appliedTo>hard/bottom,soft/x1</appliedTo><valueEvent date='0' value='1'/>"
      "<direction x='1' y='0' z='0'/><unit>N</unit></load></loads>",
      "both.lml", again);
  EXPECT_EQ(loads[0].particles.size(), again.group("hard/bottom").size() + again.group("soft/x1").size());
}

/// After 400 steps; of the bodies apart, the rows of one behind those of the other.
struct ApartAndTogether {
  State apart, together;
};

ApartAndTogether apart_and_together(const TwoOrgans& organs, const char* backend) {
  const Model both = organs.both();
  Scene scene = Scene(both).gravity({0, 0, -9.81}), soft_scene = Scene(organs.soft).gravity({0, 0, -9.81}),
        hard_scene = Scene(organs.hard).gravity({0, 0, -9.81});
  act(scene, both, "soft/", "x0", "x1");
  act(soft_scene, organs.soft, "", "x0", "x1");
  act(scene, both, "hard/", "bottom", "top");
  act(hard_scene, organs.hard, "", "bottom", "top");
  const SolverOptions options = options_for({backend, 1});
  const auto together = make_solver(backend, both, scene, {}, options);
  const auto soft = make_solver(backend, organs.soft, soft_scene, {}, options);
  const auto hard = make_solver(backend, organs.hard, hard_scene, {}, options);
  const double dt = 0.4 * together->stable_step();
  for (Solver* solver : {together.get(), soft.get(), hard.get()}) {
    const StepReport report = solver->step(400, dt);
    EXPECT_TRUE(report.ok()) << report.message();
    EXPECT_FALSE(report.force_clamped);
  }
  State apart = soft->read();
  const State second = hard->read();
  apart.position.insert(apart.position.end(), second.position.begin(), second.position.end());
  apart.velocity.insert(apart.velocity.end(), second.velocity.begin(), second.velocity.end());
  return {apart, together->read()};
}

TEST(SeveralBodies, EachMovesAsAloneToTheLastBitInTheReference) {
  const auto [apart, together] = apart_and_together(TwoOrgans(), "reference");
  ASSERT_EQ(apart.position.size(), together.position.size());
  for (std::size_t i = 0; i < apart.position.size(); ++i) {
    ASSERT_EQ(together.position[i], apart.position[i]) << i;
    ASSERT_EQ(together.velocity[i], apart.velocity[i]) << i;
  }
}

/// In single precision clusters differ, and with them the order of sums.
TEST(SeveralBodies, EachMovesAsAloneWithinRoundingOnTheProcessor) {
  const TwoOrgans organs;
  const auto [apart, together] = apart_and_together(organs, "cpu");
  const double worst = largest_distance(together.position, apart.position), spacing = mean_spacing(organs.soft);
  RecordProperty("worst_over_spacing", std::to_string(worst / spacing));
  EXPECT_LT(worst, 1e-5 * spacing);
}

/// With a body that does not act on it whatever it does: the other one's fate changes no bit.
TEST(SeveralBodies, OneBodyDoesNotFeelWhatHappensToTheOther) {
  const Model both = TwoOrgans().both();
  for (const BackendCase& backend : cpu_backends) {
    State end[2];
    for (int k = 0; k < 2; ++k) {
      Scene scene = Scene(both).gravity({0, 0, -9.81}).fix("soft/x0").fix("hard/bottom");
      if (k == 1) scene.add(pull(both, "hard/top", {0, 0, 1}, {{0, 0}, {0.01, 0.003}}));
      const auto solver = make_solver(backend.name, both, scene, {}, options_for(backend));
      ASSERT_TRUE(solver->step(200, 0.4 * solver->stable_step()).ok());
      end[k] = solver->read();
    }
    const std::vector<Index> soft = both.group("soft");
    for (const Index i : soft) ASSERT_EQ(end[0].position[i], end[1].position[i]) << backend.name << ' ' << i;
    EXPECT_NE(end[0].position[both.group("hard/top").front()], end[1].position[both.group("hard/top").front()]);
  }
}

TEST(SeveralBodies, TheStableStepIsTheSmallestAndItsBodyIsNamed) {
  const TwoOrgans organs;
  const Model both = organs.both();
  const TopologyTextures topology = build_topology(both);
  const std::vector<BodyLimit> limits = body_limits(both, topology);
  ASSERT_EQ(limits.size(), 2u);
  const auto alone = [](const Model& model) {
    const TopologyTextures t = build_topology(model);
    return stable_step(estimate_spectrum(t, t.rest), 1.0);
  };
  EXPECT_NEAR(limits[0].stable_step, alone(organs.soft), 2e-3 * limits[0].stable_step);
  EXPECT_NEAR(limits[1].stable_step, alone(organs.hard), 2e-3 * limits[1].stable_step);
  EXPECT_LT(limits[1].stable_step, limits[0].stable_step);
  const double all = stable_step(estimate_spectrum(topology, topology.rest), 1.0);
  EXPECT_NEAR(all, limits[1].stable_step, 2e-3 * all);
  const std::string text = describe(limits);
  EXPECT_EQ(text.rfind("\"hard\" sets the stable step of ", 0), 0u) << text;
  EXPECT_TRUE(says(text, ", \"soft\" by itself allows "));
}

TEST(SeveralBodies, WhatCannotBeMergedIsRefused) {
  const TwoOrgans organs;
  const Model bare = make_tetrahedron(0.01), flat = make_strip(0.02, 0.01, 2, 1);
  const auto refused = [](std::vector<NamedBody> bodies) { return message_of([&] { merge_models(bodies); }); };
  EXPECT_TRUE(says(refused({}), "one body or more"));
  EXPECT_TRUE(says(refused({{"a/b", &bare}}), "without '/'"));
  EXPECT_TRUE(says(refused({{"a", &bare}, {"a", &bare}}), "another body has it"));
  EXPECT_TRUE(says(refused({{"a", &bare}, {"Bodies", &bare}}), "\"Bodies\": expected a name of its own"));
  EXPECT_TRUE(says(refused({{"a", &bare}, {"b", &flat}}), "expected 3 dimensions"));
  EXPECT_TRUE(says(refused({{"a", &organs.soft}, {"b", &bare}}), "a material on every body or on none"));
  const Load load{.particles = {0, 2}, .toward = -1};
  EXPECT_EQ(for_merged(load, 7).particles, (std::vector<Index>{7, 9}));
  EXPECT_EQ(for_merged(load, 7).toward, -1);
}

TEST(SeveralBodies, ALoadOnBothPushesTheOneThatNothingHolds) {
  const Model model = TwoOrgans().both();
  const auto first_pushed = [&](const std::vector<Index>& particles) {
    Scene scene(model);
    scene.fix(model.group("soft/x0"));
    scene.add({.type = LoadType::force, .particles = particles, .events = {{0, 1}}, .direction = {0, 0, 1}});
    return first_loose(scene);
  };
  EXPECT_EQ(first_pushed(every_particle(model)), model.group("hard").front());
  EXPECT_EQ(first_pushed(model.group("hard")), model.group("hard").front());
  EXPECT_EQ(first_pushed(model.group("soft")), -1);
}

/// Wherever the bodies with spare particles stand in the list.
TEST(SeveralBodies, SpareParticlesComeAfterAllBodies) {
  const Model block = with_material(make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.2, 1), {5e3, 0.4, 1000.0});
  Simulation sim({{"left", with_spare_particles(block, 100)},
                  {"right", with_spare_particles(moved(block, {0.05, 0, 0}), 50)},
                  {"far", moved(block, {0.2, 0, 0})}},
                 {.backend = "reference"});
  const Index bodies = 3 * block.particle_count();
  EXPECT_EQ(sim.model().particle_count(), bodies + 150);
  EXPECT_EQ(sim.model().group("left").size(), block.rest.size());
  EXPECT_EQ(sim.model().group("far").back(), bodies - 1);
  EXPECT_EQ(sim.model().group("right/x1").size(), block.group("x1").size());
  ASSERT_TRUE(sim.cut(cut_plane({0.071, 0, 0}, {1, 0, 0})));
  EXPECT_EQ(connected_bodies(sim.model()).size(), 4u);
}

/// As in a lattice: no cell is divided, so that all keep their whole volume.
TEST(SeveralBodies, OfACutAlongFacesAreTwo) {
  const Model block = with_material(make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.0, 1), {5e3, 0.4, 1000.0});
  Simulation sim(with_spare_particles(block, 300), {.backend = "reference"});
  ASSERT_TRUE(sim.cut(cut_plane({0, 0, 0.02}, {0, 0, 1})));
  EXPECT_EQ(connected_bodies(sim.model()).size(), 2u);
  FollowedSurface surface;
  surface.of(sim.scene());
  CutSurface further = cut_plane({0.034, 0, 0}, {1, 0, 0.1});
  further.front = [](const Vec3& x) { return 0.023 - x.z(); };
  ASSERT_TRUE(sim.cut(further));
  EXPECT_EQ(surface.of(sim.scene())->body_of, make_contact_surface(sim.model()).body_of);
}

/// As mesh files have them. Their corners stay with either side of a cut, or with what is removed.
TEST(SeveralBodies, OuterTrianglesHoldNoPiecesTogether) {
  Model block = make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.0, 1);
  for (const auto& [a, b, c] : surface_triangles(block)) {
    block.cells.push_back({.type = CellType::triangle, .particles = {a, b, c}});
  }
  block = with_material(block, {5e3, 0.4, 1000.0});
  Simulation sim(with_spare_particles(block, 300), {.backend = "reference"});
  const Snapshot whole = sim.snapshot();
  ASSERT_TRUE(sim.cut(cut_plane({0, 0, 0.013}, {0, 0, 1})));
  EXPECT_EQ(connected_bodies(sim.model()).size(), 2u);
  sim.restore(whole);
  const Model& model = sim.model();
  sim.remove_cells(model.cells_in([](const Vec3& x) { return std::abs(x.x() - 0.02) < 0.0101; }));
  ASSERT_EQ(connected_bodies(model).size(), 2u);
  sim.remove_cells(connected_bodies(model).back().cells);
  EXPECT_EQ(connected_bodies(model).size(), 1u);
}

}  // namespace
}  // namespace phymul
