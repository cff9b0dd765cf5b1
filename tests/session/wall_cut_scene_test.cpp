// SPDX-License-Identifier: MIT
//
// What follows walls that are cut: loads, fluids, contacts, blades, rest shapes.
#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <numbers>

#include "interaction/contact_surface.h"
#include "model/closed_surface.h"
#include "support/cut_bodies.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

/// Pressure on a cut surface pushes as much as on the whole one, and springs on it have the whole area.
TEST(WallCutScene, PressureKeepsItsForce) {
  const Model block =
      with_material(make_tetrahedral_block({sheet_side, sheet_side, 0.02}, 8, 8, 2, 0.2, 3), {5e3, 0.4, 1000.0});
  const auto below = [](const Vec3& x) { return x.z() < 1e-9; };
  for (const Model& body : {sheet(), block}) {
    Simulation sim(with_spare_particles(body, 300), without_material("reference"));
    Load load{.type = LoadType::pressure, .events = {{0.0, 100.0}}, .direction = {0, 0, 1}};
    load.particles = body.particles_in(below);
    sim.scene().add(load);
    const auto push = [&] {
      LoadFrame frame;
      sim.scene().prepare(frame);
      sim.scene().evaluate(0.0, frame);
      return sum(frame.force);
    };
    const Snapshot whole = sim.snapshot();
    const Vec3 before = push();
    EXPECT_NEAR(before.norm(), 100.0 * sheet_side * sheet_side, 1e-9);
    CutSurface cut = cut_plane({0.052, 0.0, 0.0}, {1.0, 0.2, 0.0});
    ASSERT_TRUE(sim.cut(cut));
    EXPECT_LT((push() - before).norm(), 1e-9);
    cut = cut_plane({0.0, 0.03, 0.0}, {0.1, 1.0, 0.0});
    cut.front = [](const Vec3& x) { return 0.07 - x.x(); };
    ASSERT_TRUE(sim.cut(cut));
    EXPECT_LT((push() - before).norm(), 1e-9);
    sim.scene().attach(sim.model().particles_in(below), World{}, {.stiffness = 1e6});
    double area = 0.0;
    for (const JointSpring& spring : sim.scene().joints().back().joint.springs) area += spring.share;
    EXPECT_NEAR(area, sheet_side * sheet_side, 1e-12);
    sim.restore(whole);
    EXPECT_EQ(sim.scene().loads().back().particles, body.particles_in(below));
    EXPECT_LT((push() - before).norm(), 1e-9);
  }
}

/// A fin on a body is touched from both sides, whole and cut.
TEST(WallCutScene, AFinOnABodyIsTouched) {
  for (const bool is_cut : {false, true}) {
    for (const double side : {-1.0, 1.0}) {
      Simulation sim(with_spare_particles(block_with_fin(), 60), without_material("cpu"));
      sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.z() < 1e-9; }));
      if (is_cut) {
        ASSERT_TRUE(sim.cut(cut_plane({0.022, 0.0, 0.0}, {1.0, 0.0, 0.1})));
      }
      const ContactSurface surface = make_contact_surface(sim.model());
      for (const ContactSurface::Triangle& triangle : surface.triangles) {
        const auto is_of_fin = [&](Index corner) { return surface.rest[corner].z() > 0.02 - 1e-9; };
        const auto is_high = [&](Index corner) { return surface.rest[corner].z() > 0.02 + 1e-9; };
        const bool fin =
            std::ranges::all_of(triangle.corner, is_of_fin) && std::ranges::any_of(triangle.corner, is_high);
        EXPECT_EQ(triangle.has_inside, !fin);
      }
      constexpr double radius = 4e-3;
      ToolPose pose{.position = {0.012, 0.01 + side * (radius + 1e-3), 0.026}};
      Tool ball{.shape = Sphere{radius}, .pose = pose};
      ball.contact = ToolContact::surface;
      const ToolHandle tool = sim.scene().add_tool("ball", ball);
      for (int tick = 0; tick < 40; ++tick) {
        pose.position.y() -= side * 5e-5;
        tool.move_to(pose);
        ASSERT_TRUE(sim.advance(1e-3).ok());
      }
      EXPECT_GT(side * sim.force_on(tool).mean_force.y(), 0.0);
    }
  }
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

/// Where a cut was undone there is no tissue around what its copies held.
TEST(WallCutScene, UndoneCopiesHoldNoFluid) {
  Simulation sim(with_spare_particles(slab_in_capsule(), 300), without_material("cpu"));
  const Snapshot whole = sim.snapshot();
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1})));
  const Index copy = sim.cuts().back()->copies.front().particle;
  const auto cell = std::ranges::find_if(sim.model().cells, [&](const Cell& one) {
    return one.type == CellType::tetrahedron && std::ranges::find(one.particles, copy) != one.particles.end();
  });
  ASSERT_NE(cell, sim.model().cells.end());
  const auto& p = cell->particles;
  VolumeConstraint filled{.triangles = {{p[0], p[2], p[1]}, {p[0], p[1], p[3]}, {p[1], p[2], p[3]}, {p[2], p[0], p[3]}},
                          .volume = 0.0,
                          .applied_to = {}};
  filled.volume = 1.1 * enclosed_volume(filled.triangles, sim.model().rest);
  sim.scene().constrain_volume(filled);
  const Snapshot parted = sim.snapshot();
  ASSERT_TRUE(sim.advance(0.001).ok());
  EXPECT_FALSE(sim.scene().is_open(0));
  sim.restore(whole);
  EXPECT_TRUE(sim.scene().is_open(0));
  ASSERT_TRUE(sim.advance(0.001).ok());
  EXPECT_LT(sim.max_displacement(), 1e-9);
  sim.restore(parted);
  EXPECT_FALSE(sim.scene().is_open(0));
}

TEST(WallCutScene, TheAxisOfARotationStays) {
  Simulation sim(with_spare_particles(sheet(), 100), without_material("reference"));
  const std::vector<Index> end = sim.model().particles_in([](const Vec3& x) { return x.x() > 0.08; });
  sim.scene().add({.type = LoadType::rotation, .particles = end, .events = {{0.0, 0.5}}, .direction = {1, 0, 0}});
  const auto targets = [&] {
    LoadFrame frame;
    sim.scene().prepare(frame);
    sim.scene().evaluate(0.0, frame);
    return frame.target;
  };
  const VecList before = targets();
  CutSurface slit = cut_plane({0.0, 0.03, 0.0}, {0.1, 1.0, 0.0});
  slit.front = [](const Vec3& x) { return 0.07 - x.x(); };
  ASSERT_TRUE(sim.cut(slit));
  ASSERT_GT(sim.scene().loads()[0].particles.size(), end.size());
  const VecList after = targets();
  for (const Index i : end) EXPECT_LT((after[i] - before[i]).norm(), 1e-15) << i;
  for (const BodyCut::Copy& copy : sim.cuts().back()->copies) EXPECT_EQ(after[copy.particle], after[copy.of]);
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

TEST(WallCutScene, SheetsWithSlitsLieOnEachOther) {
  const Model low = sheet(10);
  Model high = sheet(7);
  for (Vec3& x : high.rest) x = 0.61 * x + Vec3(0.0203, 0.0187, 0.004);
  Simulation sim(with_spare_particles(merged({{"low", &low}, {"high", &high}}), 100), without_material("cpu"));
  sim.scene().gravity({0, 0, -9.81}).contacts({});
  sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.z() < 1e-9; }));
  for (const bool lower : {true, false}) {
    CutSurface slit = cut_plane({lower ? 0.092 : 0.051, 0.0, 0.0}, {1.0, 0.1, 0.0});
    slit.front = [](const Vec3& x) { return 0.04 - x.y(); };
    slit.distance = [lower, all = slit.distance](const Vec3& x) { return (x.z() < 0.002) == lower ? all(x) : 1.0; };
    ASSERT_TRUE(sim.cut(slit));
  }
  ASSERT_TRUE(sim.advance(0.2).ok());
  const State state = sim.solver().read();
  for (Index i = 0; i < high.particle_count(); ++i) EXPECT_GT(state.position[low.particle_count() + i].z(), 0.0) << i;
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

/// The force along the motion is toughness times thickness at any inclination of the edge. A restored blade repeats it.
TEST(WallCutScene, BladeFeelsToughnessTimesThickness) {
  for (const double lean : {0.0, 30.0, -45.0}) {
    SCOPED_TRACE(lean);
    Material stiff = film;
    stiff.young = lean == 0.0 ? 100e3 : 5e6;  // or a leaning edge bends the sheet aside
    Simulation sim(with_spare_particles(make_wall(square(15, 0.2), {.material = stiff}), 200), without_material("cpu"));
    sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.x() < 1e-9 || x.x() > sheet_side - 1e-9; }));
    const Mat3 upright = (Mat3() << 0, 1, 0, 0, 0, -1, -1, 0, 0).finished();
    const Eigen::AngleAxisd leaning(lean * std::numbers::pi / 180.0, Vec3::UnitX());
    ToolPose pose{.position = {0.047, -0.01, 0.0}, .orientation = Quaternion(leaning * upright)};
    const ToolHandle blade =
        sim.scene().add_tool("blade", {.shape = Blade{.width = 0.03, .toughness = 20.0}, .pose = pose});
    const auto go_on = [&] {
      pose.position.y() += 2e-4;
      blade.move_to(pose);
      EXPECT_TRUE(sim.advance(1e-3).ok());
    };
    for (int tick = 0; tick < 200; ++tick) go_on();
    const Snapshot half_way = sim.snapshot();
    const ToolPose there = pose;
    double sum = 0.0;
    for (int tick = 0; tick < 200; ++tick) {
      go_on();
      sum -= sim.force_on(blade).mean_force.y();
    }
    EXPECT_NEAR(sum / 200.0 / (20.0 * film.thickness), 1.0, lean == 0.0 ? 0.02 : 0.1);
    const State later = sim.solver().read();
    sim.restore(half_way);
    pose = there;
    for (int tick = 0; tick < 200; ++tick) go_on();
    EXPECT_EQ(sim.solver().read(), later);
  }
}

/// N, at an end of a slit sheet that is drawn by 1 mm between two held ends.
double force_of(const Model& model) {
  Simulation sim(model, without_material("reference"));
  sim.scene().fix(model.particles_in([](const Vec3& x) { return x.x() < 1e-9; }));
  Load draw{.type = LoadType::translation, .events = {{0.0, 1e-3}}, .direction = {1, 0, 0}};
  draw.particles = model.particles_in([](const Vec3& x) { return x.x() > sheet_side - 1e-9; });
  sim.scene().add(draw);
  EXPECT_TRUE(sim.solve_static({.tolerance = 1e-7}).converged());
  const VecList force = forces_at(sim.solver().topology(), sim.solver().read().position);
  double sum = 0.0;
  for (const Index i : draw.particles) sum -= force[i].x();
  return sum;
}

/// Against sheets of 120 x 120 cells with the same slits, half way through, of which the straight one lies along edges.
TEST(WallCutScene, SlitsTakeTheForceThatTheyTakeInFineSheets) {
  for (const double slope : {0.0, std::tan(17.0 * std::numbers::pi / 180.0)}) {
    const double fine = slope == 0.0 ? 0.024229 : 0.024346;  // N
    double mean = 0.0;
    int count = 0;
    for (const double aside : {0.0, 0.0021, 0.0047}) {
      for (const double jitter : {0.0, 0.2}) {
        const CutSurface slit{.distance = [=](const Vec3& x) { return x.x() - 0.05 - aside - slope * (x.y() - 0.025); },
                              .front = [](const Vec3& x) { return x.y() - 0.05; }};
        const double off = force_of(cut_body(sheet(16, jitter), slit)) / fine - 1.0;
        EXPECT_LT(std::abs(off), 0.027) << aside << ' ' << jitter;
        mean += off;
        ++count;
      }
    }
    EXPECT_LT(std::abs(mean / count), 0.013);
  }
}

/// A blade leaves what it cannot cut, and says so; a cut at once refuses it.
TEST(WallCutScene, ACapsuleOnHexahedraIsLeft) {
  Model model = with_material(make_block({0.06, 0.04, 0.02}, 6, 4, 2), {5e3, 0.4, 1000.0});
  add_capsule(model, film);
  Simulation sim(with_spare_particles(model, 100), without_material("cpu"));
  EXPECT_TRUE(says(message_of([&] { sim.cut(cut_plane({0.033, 0.0, 0.0}, {1.0, 0.0, 0.0})); }), "tetrahedra or walls"));
  ToolPose pose{.position = {0.03, 0.017, 0.025}};
  const ToolHandle blade = sim.scene().add_tool("blade", {.shape = Blade{.width = 0.02}, .pose = pose});
  int uncut = 0;
  for (int tick = 0; tick < 20; ++tick) {
    pose.position.z() -= 1e-3;
    blade.move_to(pose);
    const StepReport report = sim.advance(1e-3);
    ASSERT_TRUE(report.ok());
    uncut += report.uncut;
  }
  EXPECT_GT(uncut, 0);
  EXPECT_TRUE(sim.cuts().empty());
}

/// What walls do not have is refused while they are removed, too: they may come back.
TEST(WallCutScene, RemovedWallsAreRefusedAsOthersAre) {
  Simulation sim(block_with_fin(), without_material("cpu"));
  const auto cells = static_cast<Index>(sim.model().cells.size());
  std::vector<Index> fin;
  for (Index row = 0; row < cells; ++row) {
    if (sim.model().cells[row].type == CellType::triangle) fin.push_back(row);
  }
  sim.remove_cells(fin);
  EXPECT_TRUE(says(message_of([&] { sim.scene().scale_stiffness(2.0); }), "without walls"));
  EXPECT_TRUE(says(message_of([&] { sim.scene().tear({.toughness = 1.0}); }), "without walls"));
}

TEST(WallCutScene, WrongCutsAreRefused) {
  Model cut = cut_body(with_material(slab(), {5e3, 0.4, 1000.0}), cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1}));
  EXPECT_TRUE(says(message_of([&] { add_capsule(cut, film); }), "without cuts"));
  CutSurface nowhere = cut_plane({0.05, 0.0, 0.0}, {1.0, 0.0, 0.0});
  nowhere.front = [](const Vec3&) { return std::nan(""); };
  EXPECT_TRUE(says(message_of([&] { cut_body(sheet(), nowhere); }), "distances to the front"));
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
