// SPDX-License-Identifier: MIT
//
// Scene::tear: when and where tissue tears.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cmath>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

constexpr double width = 0.06, depth = 0.015, height = 0.12;  // m

Model strip(double spacing, int seed) {
  const auto particles = [&](double side) { return static_cast<int>(std::lround(side / spacing)) + 1; };
  Model model =
      make_tetrahedral_block({width, depth, height}, particles(width), particles(depth), particles(height), 0.2, seed);
  set_material(model, {1e4, 0.3, 1000.0});
  return with_spare_particles(std::move(model), static_cast<int>(12.0 * width * depth / (spacing * spacing)));
}

/// From the side, `length` deep, m; `slope`: rad, by which it rises.
CutSurface notch(double length, double slope = 0.0) {
  CutSurface cut = cut_plane({0, 0, slope == 0.0 ? 0.0607 : 0.0507}, {-std::sin(slope), 0, std::cos(slope)});
  cut.front = [=](const Vec3& x) { return x.x() - length * std::cos(slope); };
  return cut;
}

/// Held below, drawn at the top, in plane strain; `by`: m, of the top.
Simulation drawn_strip(double spacing, int seed, const CutSurface& cut, std::vector<ValueEvent> by,
                       const std::string& backend = "cpu") {
  SimulationOptions options;
  options.backend = backend;
  options.damping.rate = 20.0;
  Simulation sim(strip(spacing, seed), options);
  sim.cut(cut);
  sim.scene().fix("z0").add({.type = LoadType::translation,
                             .particles = sim.model().group("z1"),
                             .events = std::move(by),
                             .direction = {0, 0, 1}});
  for (const char* const face : {"y0", "y1"}) {
    sim.scene().add({.type = LoadType::translation,
                     .particles = sim.model().group(face),
                     .events = {{0.0, 0.0}},
                     .axes = {Axis::free, Axis::driven, Axis::free},
                     .direction = {0, 1, 0}});
  }
  return sim;
}

/// J/m^2 at 1 mm: half the motion times what the force on the top falls by as the notch grows.
double energy_release() {
  const auto force = [](double length) {
    double sum = 0.0;
    for (const int seed : {1, 2, 3}) {
      Simulation sim = drawn_strip(0.004, seed, notch(length), {{0.0, 1e-3}});
      EXPECT_TRUE(sim.solve_static().converged());
      const VecList forces = forces_at(sim.solver().topology(), sim.state().position);
      for (const Index i : sim.model().group("z1")) sum -= forces[i].z() / 3.0;
    }
    return sum;
  };
  return 0.5 * 1e-3 * (force(0.012) - force(0.024)) / 0.012 / depth;
}

constexpr double toughness = 1.0;  // J/m^2

TEST(Tear, OfANotchedStripIsAtGriffithsLoad) {
  const double release = energy_release();
  EXPECT_NEAR(release, 0.041, 0.003);
  const double due = 1e-3 * std::sqrt(toughness / release);  // m
  double sum = 0.0;
  int runs = 0;
  for (const double spacing : {0.006, 0.005, 0.004}) {
    for (const int seed : {1, 2}) {
      Simulation sim = drawn_strip(spacing, seed, notch(0.018), {{0.0, 0.0}});
      sim.scene().tear({.toughness = toughness});
      double drawn = 0.8;  // of what is due
      for (; drawn < 1.3; drawn *= 1.02) {
        sim.scene().set_events(1, std::vector<ValueEvent>{{0.0, drawn * due}});
        ASSERT_TRUE(sim.solve_static().converged());
        const StepReport report = sim.step(1, 1e-4);
        ASSERT_TRUE(report.ok()) << report.message();
        if (report.torn > 0) break;
      }
      std::printf("spacing %.0f mm: tears at %.3f of Griffith's load\n", 1e3 * spacing, drawn);
      EXPECT_NEAR(drawn, 1.0, 0.12) << spacing << ' ' << seed;
      sum += drawn;
      ++runs;
    }
  }
  EXPECT_NEAR(sum / runs, 1.0, 0.05);
}

/// Mean height of what tore between two widths, m.
double height_of_tear(const Simulation& sim, std::size_t first_cut, double from, double to) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t k = first_cut; k < sim.cuts().size(); ++k) {
    for (const BodyCut::Change& change : sim.cuts()[k]->changed) {
      if (change.after.cuts.size() == change.before.cuts.size()) continue;
      Vec3 middle = Vec3::Zero();
      for (const Index i : change.before.particles) middle += 0.25 * sim.model().rest[i];
      if (middle.x() < from || middle.x() > to) continue;
      sum += middle.z();
      ++count;
    }
  }
  return sum / count;
}

/// A tear that begins at a notch of 45 degrees turns straight across the pull, and parts the strip.
TEST(Tear, TurnsAcrossThePull) {
  const double slope = 0.25 * 3.14159265358979;
  Simulation sim = drawn_strip(0.005, 1, notch(0.018, slope), {{0.0, 0.0}, {2.0, 0.02}});
  sim.scene().tear({.toughness = toughness});
  ASSERT_EQ(connected_bodies(sim.model()).size(), 1u);
  int torn = 0;
  while (sim.time() < 0.8) {
    const StepReport report = sim.advance(1e-3);
    ASSERT_TRUE(report.ok()) << report.message();
    EXPECT_EQ(report.uncut, 0);
    torn += report.torn;
  }
  EXPECT_GT(torn, 100);
  EXPECT_EQ(connected_bodies(sim.model()).size(), 2u);
  const double end = 0.0507 + 0.018 * std::sin(slope);  // m, height of the notch's
  EXPECT_NEAR(height_of_tear(sim, 1, 0.02, 0.035), end, 0.004);
  EXPECT_NEAR(height_of_tear(sim, 1, 0.045, 0.06), end, 0.004);
}

/// A tool grasps the middle of a slab's top and draws it away; `law`: null: it does not tear.
Simulation pulled_slab(const Tearing* law) {
  Model model = make_tetrahedral_block({0.05, 0.05, 0.02}, 11, 11, 5, 0.2, 1);
  set_material(model, {5e3, 0.3, 1000.0});
  SimulationOptions options;
  options.backend = "cpu";
  options.damping.rate = 20.0;
  Simulation sim(with_spare_particles(std::move(model), 600), options);
  sim.scene().fix("z0");
  if (law != nullptr) sim.scene().tear(*law);
  ToolPose pose{.position = {0.025, 0.025, 0.024}};
  const auto tool = sim.scene().add_tool("forceps", {.shape = Sphere{0.005}, .pose = pose});
  tool.grasp(0.002);
  for (int tick = 0; tick < 500; ++tick) {
    pose.position.z() += 5e-5;
    tool.move_to(pose);
    const StepReport report = sim.advance(1e-3);
    EXPECT_TRUE(report.ok()) << report.message();
  }
  return sim;
}

TEST(Tear, BeginsWhereAToolPulls) {
  const Tearing weak{.toughness = 5.0}, tough{.toughness = 5e3};
  EXPECT_TRUE(pulled_slab(nullptr).cuts().empty());
  EXPECT_TRUE(pulled_slab(&tough).cuts().empty());
  Simulation whole = pulled_slab(nullptr), torn = pulled_slab(&weak);
  EXPECT_FALSE(torn.cuts().empty());
  const auto force = [](Simulation& sim) { return -sim.solver().tool_force("forceps").force.z(); };
  EXPECT_GT(force(whole), 0.1);  // N
  EXPECT_LT(force(torn), 0.5 * force(whole));
}

/// At an interface, where the particle that bears most belongs to both.
TEST(Tear, PartsOnlyTheMaterialThatTears) {
  Model model = make_tetrahedral_block({0.06, 0.04, 0.02}, 12, 8, 4, 0.2, 3);
  const Material weak{1e4, 0.3, 1000.0}, tough{1.0001e4, 0.3, 1000.0};
  set_material(model, weak);
  set_material(model, tough, [](const Vec3& place) { return place.x() > 0.03; });
  model = with_spare_particles(std::move(model), 300);
  Simulation sim(model, {.backend = "cpu", .damping = {.rate = 20.0}});
  sim.scene().fix("z0").tear(weak, {.toughness = 0.02});
  ToolPose pose{.position = {0.03, 0.012, 0.0235}};
  const ToolHandle forceps = sim.scene().add_tool("forceps", {.shape = Sphere{0.004}, .pose = pose});
  forceps.grasp(0.003);
  for (int tick = 0; tick < 100 && sim.cuts().empty(); ++tick) {
    forceps.move_to(pose);
    ASSERT_TRUE(sim.advance(1e-3).ok());
    pose.position.z() += 1e-4;
  }
  ASSERT_FALSE(sim.cuts().empty());
  for (const Cell& cell : sim.model().cells) {
    EXPECT_TRUE(cell.cuts.empty() || sim.model().materials[cell.material] == weak);
  }
}

/// What tore is part of snapshots and recordings, as cuts are.
TEST(Tear, IsUndoneAndReplayed) {
  Simulation sim = drawn_strip(0.006, 1, notch(0.018), {{0.0, 0.0}, {1.0, 0.01}});
  sim.scene().tear({.toughness = toughness});
  const Snapshot before = sim.snapshot();
  const auto run = [&] {
    int torn = 0;
    while (sim.time() < 0.6) torn += sim.advance(2e-3).torn;
    return torn;
  };
  const int torn = run();
  EXPECT_GT(torn, 10);
  const State there = sim.state();
  const std::size_t cuts = sim.cuts().size();
  sim.restore(before);
  EXPECT_EQ(sim.cuts().size(), 1u);
  EXPECT_EQ(run(), torn);
  EXPECT_EQ(sim.cuts().size(), cuts);
  EXPECT_EQ(sim.state(), there);

  sim.restore(before);
  sim.record();
  run();
  Simulation again = drawn_strip(0.006, 1, notch(0.018), {{0.0, 0.0}, {1.0, 0.01}});
  again.replay(sim.recording());
  EXPECT_EQ(again.snapshot(), sim.snapshot());

  // The law is part of the scene: it tears on, and as it was changed meanwhile.
  EXPECT_EQ(again.scene().tearing(), sim.scene().tearing());
  sim.scene().tear(sim.model().materials[0], {.toughness = 0.5 * toughness, .radius = 0.01});
  sim.step(1, 1e-5);
  again.replay(sim.recording());
  EXPECT_EQ(again.scene().tearing(), sim.scene().tearing());
  sim.scene().tear({});
  sim.step(1, 1e-5);
  again.replay(sim.recording());
  EXPECT_TRUE(again.scene().tearing().empty());
}

TEST(Tear, RefusesWhatItCannotDo) {
  Model model = strip(0.006, 1);
  Scene scene(model);
  EXPECT_TRUE(refuses([&] { scene.tear({.toughness = -1.0}); }, "toughness"));
  EXPECT_TRUE(refuses([&] { scene.tear({.toughness = 1.0, .radius = NAN}); }, "radius"));
  EXPECT_TRUE(refuses([&] { scene.tear({2e4, 0.3, 1000.0}, {.toughness = 1.0}); }, "a material of the model"));
  EXPECT_TRUE(scene.tearing().empty());
  scene.tear(model.materials[0], {.toughness = 1.0});
  EXPECT_EQ(scene.tearing().size(), 1u);
  EXPECT_TRUE(scene.tear({.toughness = 0.0}).tearing().empty());
  const Model plain = make_tetrahedral_block({0.01, 0.01, 0.01}, 3, 3, 3, 0.0, 1);
  Scene other(plain);
  EXPECT_TRUE(refuses([&] { other.tear({.toughness = 1.0}); }, "material"));
  const Model lattice = with_material(make_block({0.01, 0.01, 0.01}, 2, 2, 2));
  Scene of_lattice(lattice);
  EXPECT_TRUE(refuses([&] { of_lattice.tear({.toughness = 1.0}); }, "tetrahedra", "HEXAHEDRON"));
  scene.tear({.toughness = 1.0});
  EXPECT_TRUE(scene.clear().tearing().empty());
  Model points = make_block({0.01, 0.01, 0.01}, 2, 2, 2, 26);
  points.cells.clear();
  points.components.clear();
  const Model of_points = with_material(std::move(points));
  Scene without_cells(of_points);
  EXPECT_TRUE(refuses([&] { without_cells.tear({.toughness = 1.0}); }, "a body of tetrahedra"));
}

/// Another radius or toughness counts from the next call on, and bringing a body to rest tears as steps do.
TEST(Tear, FollowsAChangeOfTheLaw) {
  Simulation sim = drawn_strip(0.006, 1, notch(0.018), {{0.0, 3.5e-3}});
  sim.scene().tear({.toughness = toughness});
  ASSERT_TRUE(sim.solve_static().converged());
  EXPECT_EQ(sim.step(1, 1e-4).torn, 0);
  const Snapshot whole = sim.snapshot();
  sim.scene().tear({.toughness = 0.4 * toughness});
  EXPECT_EQ(sim.step(0, 1e-4).torn, 0);
  EXPECT_GT(sim.step(1, 1e-4).torn, 0);
  sim.restore(whole);
  sim.scene().tear({.toughness = toughness, .radius = 0.02});  // over all of the strip the mean is about the same
  const int torn = sim.step(1, 1e-4).torn;
  Simulation fresh = drawn_strip(0.006, 1, notch(0.018), {{0.0, 3.5e-3}});
  fresh.scene().tear({.toughness = toughness, .radius = 0.02});
  fresh.restore(whole);
  EXPECT_EQ(fresh.step(1, 1e-4).torn, torn);
  sim.restore(whole);
  sim.scene().tear({.toughness = 0.4 * toughness});
  EXPECT_GT(sim.run_to_rest(50).report.torn, 0);
}

using TearOn = OnEveryBackend;

TEST_P(TearOn, HappensAboveTheLoadAlone) {
  for (const double drawn : {3.5e-3, 6.5e-3}) {  // m; 4.9e-3 is due
    Simulation sim = drawn_strip(0.006, 1, notch(0.018), {{0.0, drawn}}, GetParam());
    sim.scene().tear({.toughness = toughness});
    ASSERT_TRUE(sim.solve_static().converged());
    const StepReport report = sim.step(1, 1e-4);
    ASSERT_TRUE(report.ok()) << report.message();
    EXPECT_EQ(report.torn > 0, drawn > 5e-3) << drawn;
  }
}

PHYMUL_ON_EVERY_BACKEND(TearOn);

}  // namespace
}  // namespace phymul
