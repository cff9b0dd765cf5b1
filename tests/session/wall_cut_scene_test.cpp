// SPDX-License-Identifier: MIT
//
// What follows walls that are cut: loads, fluids, contacts, blades, rest shapes.
#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <numbers>
#include <numeric>

#include "support/cut_walls.h"

namespace phymul {
namespace {

using namespace test;

/// Pressure on a cut sheet pushes as much as on the whole one.
TEST(WallCutScene, PressureKeepsItsForce) {
  Simulation sim(with_spare_particles(sheet(), 100), without_material("reference"));
  Load load{.type = LoadType::pressure, .events = {{0.0, 100.0}}, .direction = {0, 0, 1}};
  load.particles.resize(static_cast<std::size_t>(sim.model().particle_count()));
  std::iota(load.particles.begin(), load.particles.end(), 0);
  sim.scene().add(load);
  const auto push = [&] {
    LoadFrame frame;
    sim.scene().prepare(frame);
    sim.scene().evaluate(0.0, frame);
    return sum(frame.force);
  };
  const Vec3 before = push();
  EXPECT_NEAR(before.norm(), 100.0 * sheet_side * sheet_side, 1e-9);
  ASSERT_TRUE(sim.cut(cut_plane({0.052, 0.0, 0.0}, {1.0, 0.2, 0.0})));
  EXPECT_LT((push() - before).norm(), 1e-9);
}

TEST(WallCutScene, OpensABag) {
  Simulation sim(with_spare_particles(sphere(), 200), without_material("cpu"));
  sim.scene().constrain_volume(
      VolumeConstraint{surface_triangles(sim.model()), 1.1 * 4.0 / 3.0 * std::numbers::pi * std::pow(0.05, 3), "bag"});
  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_FALSE(sim.scene().any_volume_open());
  CutSurface slit = cut_plane({0.0, 0.003, 0.0}, {0.0, 1.0, 0.1});
  slit.front = [](const Vec3& x) { return 0.03 - x.z(); };
  ASSERT_TRUE(sim.cut(slit));
  EXPECT_TRUE(sim.scene().any_volume_open());
  EXPECT_TRUE(sim.advance(0.05).ok());
}

/// The halves of a cut sheet are bodies that touch others and each other.
TEST(WallCutScene, HalvesTouch) {
  Model lying = sheet(10);
  for (Vec3& x : lying.rest) x.z() = 0.012;
  const Model table = with_material(make_tetrahedral_block({0.12, 0.12, 0.01}, 4, 4, 1, 0.0, 1), {1e6, 0.3, 1000.0});
  Simulation sim(with_spare_particles(merged({{"sheet", &lying}, {"table", &table}}), 200), without_material("cpu"));
  sim.scene().gravity({0, 0, -9.81}).contacts({});
  sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.z() < 1e-9; }));
  CutSurface above = cut_plane({0.052, 0.0, 0.0}, {1.0, 0.2, 0.0});
  above.front = [](const Vec3& x) { return 1.0 - 1e2 * x.z(); };
  ASSERT_TRUE(sim.cut(above));
  ASSERT_TRUE(sim.advance(0.5).ok());
  const State state = sim.solver().read();
  for (Index i = 0; i < lying.particle_count(); ++i) EXPECT_GT(state.position[i].z(), 0.0095) << i;
}

TEST(WallCutScene, BladeCutsASheet) {
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    Simulation sim(with_spare_particles(sheet(), 200), without_material(backend));
    sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.x() < 1e-9 || x.x() > sheet_side - 1e-9; }));
    // Columns: the tool's x, y, z in the world; it cuts toward -z, here along y.
    const Mat3 turn = (Mat3() << 0, 1, 0, 0, 0, -1, -1, 0, 0).finished();
    ToolPose pose{.position = {0.047, -0.01, 0.0}, .orientation = Quaternion(turn)};
    const ToolHandle blade = sim.scene().add_tool("blade", {.shape = Blade{.width = 0.02}, .pose = pose});
    for (int tick = 0; tick < 120; ++tick) {
      pose.position.y() += 1e-3;
      blade.move_to(pose);
      const StepReport report = sim.advance(1e-3);
      ASSERT_TRUE(report.ok());
      EXPECT_EQ(report.uncut, 0);
      if (tick == 50) {
        EXPECT_EQ(connected_bodies(sim.model()).size(), 1u);
      }
    }
    EXPECT_EQ(connected_bodies(sim.model()).size(), 2u);
    EXPECT_LT(difference_of_forces(sim.solver().topology(), built_anew(sim), sim.model()), 1e-12);
  }
}

TEST(WallCutScene, RestOfASlitSheet) {
  Simulation sim(with_spare_particles(sheet(), 100), without_material("reference"));
  sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.x() < 0.015; })).gravity({0, 0, -0.2});
  CutSurface slit = cut_plane({0.0, 0.047, 0.0}, {0.03, 1.0, 0.0});
  slit.front = [](const Vec3& x) { return 0.05 - x.x(); };
  ASSERT_TRUE(sim.cut(slit));
  sim.remove_cells(std::vector<Index>{40});
  const StaticResult found = sim.solve_static();
  ASSERT_TRUE(found.converged()) << found.message();
  const State at_rest = sim.solver().read();
  ASSERT_TRUE(sim.run_to_rest().converged());
  double way = 0.0, apart = 0.0;
  const State later = sim.solver().read();
  for (std::size_t i = 0; i < later.position.size(); ++i) {
    way = std::max(way, (at_rest.position[i] - sim.model().rest[i]).norm());
    apart = std::max(apart, (later.position[i] - at_rest.position[i]).norm());
  }
  EXPECT_GT(way, 0.01);
  EXPECT_LT(apart, 3e-3 * way);
}

}  // namespace
}  // namespace phymul
