// SPDX-License-Identifier: MIT
//
// Blades: what they cut, with which force, and that every backend, snapshots and recordings have them.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <numeric>

#include "body/cut_places.h"
#include "model/cell_geometry.h"
#include "support/bodies.h"
#include "support/cut_bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/sanitized.h"
#include "topology/body_edit.h"

namespace phymul {
namespace {

using namespace test;

class BladeOn : public OnEveryBackend {};

TEST_P(BladeOn, PartsASlab) {
  Stroke stroke(GetParam(), 0.0, -0.005);
  for (int tick = 0; tick < 140; ++tick) {
    const StepReport report = stroke.go_on(0.5e-3);
    ASSERT_TRUE(report.ok()) << report.message();
    ASSERT_EQ(report.uncut, 0);
  }
  const auto pieces = connected_bodies(stroke.sim.model());
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_NEAR(pieces[0].volume + pieces[1].volume, 0.06 * 0.04 * 0.02, 1e-12);
  EXPECT_NEAR(pieces[0].volume / pieces[1].volume, 1.0, 0.1);
  EXPECT_EQ(stroke.sim.force_on(stroke.blade).force, Vec3(0, 0, 0));
  validate(stroke.sim.model());
}

TEST_P(BladeOn, CutsOnItsFirstWay) {
  Stroke at_once(GetParam(), 0.0, -0.005), seen(GetParam(), 0.0, -0.005);
  const std::size_t whole = seen.sim.model().cells.size();
  ASSERT_TRUE(seen.sim.advance(0.0).ok());
  for (Stroke* const stroke : {&at_once, &seen}) ASSERT_TRUE(stroke->go_on(0.03).ok());
  EXPECT_GT(seen.sim.model().cells.size(), whole);
  EXPECT_EQ(at_once.sim.model().cells, seen.sim.model().cells);
}

TEST_P(BladeOn, GoesOnFromASnapshotAndIsRecorded) {
  const auto make = [] { return Stroke(GetParam(), 20.0, 0.005, 1e4, 9, 600, 0, 1e3); };
  Stroke stroke = make(), other = make();
  for (int tick = 0; tick < 20; ++tick) stroke.go_on(0.2e-3);
  stroke.sim.record();
  for (int tick = 0; tick < 20; ++tick) ASSERT_TRUE(stroke.go_on(0.2e-3).ok());
  ASSERT_FALSE(stroke.sim.cuts().empty());
  ASSERT_FALSE(stroke.sim.snapshot().state.tools[0].blade.empty());
  const std::string path = testing::TempDir() + "blade_" + GetParam() + ".state";
  stroke.sim.save(path);
  const Snapshot half_way = stroke.sim.snapshot();
  const ToolPose pose = stroke.pose;
  for (int tick = 0; tick < 20; ++tick) stroke.go_on(0.2e-3);
  const Snapshot end = stroke.sim.snapshot();

  Stroke again = make();
  again.sim.replay(stroke.sim.recording());
  EXPECT_EQ(again.sim.snapshot(), end);

  stroke.sim.restore(half_way);
  stroke.pose = pose;
  for (int tick = 0; tick < 20; ++tick) stroke.go_on(0.2e-3);
  other.sim.load(path);
  other.pose = pose;
  for (int tick = 0; tick < 20; ++tick) other.go_on(0.2e-3);
  EXPECT_EQ(other.sim.snapshot().state, stroke.sim.snapshot().state);
  EXPECT_TRUE(equal_cuts(other.sim.cuts(), stroke.sim.cuts()));
}
PHYMUL_ON_EVERY_BACKEND(BladeOn);

/// A half of the edge's points is above the slab, and 15 mm of it are in tissue.
TEST(Blade, SteadyForceIsToughnessTimesLength) {
  for (const auto& [young, toughness] : {std::pair{1e4, 20.0}, {5e4, 60.0}}) {
    Stroke stroke("cpu", toughness, 0.005, young, 12);
    std::vector<double> forces;
    double largest_speed = 0.0;
    for (int tick = 0; tick < 1000; ++tick) {
      const StepReport report = stroke.go_on(0.05e-3);
      ASSERT_TRUE(report.ok()) << report.message();
      largest_speed = std::max(largest_speed, report.max_speed);
      if (tick > 350 && tick < 900) forces.push_back(stroke.sim.force_on(stroke.blade).mean_force.x());
    }
    const double mean = std::accumulate(forces.begin(), forces.end(), 0.0) / static_cast<double>(forces.size());
    printf("E %.0f, toughness %.0f: force %.4f of the law's, largest speed %.2f m/s\n", young, toughness,
           mean / (toughness * 0.015), largest_speed);
    EXPECT_NEAR(mean / (toughness * 0.015), 1.0, 0.05);
    EXPECT_EQ(connected_bodies(stroke.sim.model()).size(), 1u);
  }
}

/// Through a strip whose long sides are held 8 % further apart, where what it parts springs back: 0.07 of the work then
/// comes from the strip besides.
TEST(Blade, WorkPerAreaIsTheToughnessAlsoUnderTension) {
  constexpr double toughness = 20.0, thickness = 0.01, by = 0.05e-3;  // J/m2, m, m
  for (const double stretch : {0.0, 0.08}) {
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, thickness}, 12, 8, 2, 0.25, 7), 900),
                   {.material = {1e4, 0.45, 1000.0}, .backend = "cpu", .damping = {.rate = 40.0}});
    for (const double side : {-0.5, 0.5}) {
      Load load{.type = LoadType::translation,
                .particles = sim.model().group(side < 0.0 ? "y0" : "y1"),
                .events = {{0.0, 0.0}, {0.2, 0.04 * stretch * side}},
                .direction = {0, 1, 0}};
      load.axes = {Axis::driven, Axis::driven, Axis::driven};
      sim.scene().add(load);
    }
    ASSERT_TRUE(sim.advance(0.6).ok());
    ToolPose pose = Stroke::first(-0.015);  // its middle in that of the thickness
    const ToolHandle blade =
        sim.scene().add_tool("scalpel", {.shape = Blade{.width = 0.04, .toughness = toughness}, .pose = pose});
    double work = 0.0;
    for (int tick = 0; tick < 850; ++tick) {
      pose.position.x() -= by;
      blade.move_to(pose);
      ASSERT_TRUE(sim.advance(1e-3).ok());
      if (tick >= 400) work += by * sim.force_on(blade).mean_force.x();
    }
    EXPECT_NEAR(work / (450 * by * thickness * toughness), 1.0, 0.05) << stretch;
  }
}

/// Sides of 10 mm behind the edge: on the way in each of them is in tissue as far as the edge, and on the way out,
/// where nothing is cut, they alone resist.
TEST(Blade, SidesRubByTheirAreaInTissue) {
  constexpr double friction = 1500.0, height = 0.01, length = 0.015, by = 0.05e-3;
  for (const double toughness : {20.0, 0.0}) {
    SCOPED_TRACE(toughness);
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.02}, 12, 8, 4, 0.25, 7), 600),
                   {.material = {5e4, 0.45, 1000.0}, .backend = "cpu", .damping = {.rate = 20.0}});
    ToolPose pose = Stroke::first(0.005);
    const ToolHandle blade = sim.scene().fix("z0").add_tool(
        "scalpel",
        {.shape = Blade{.width = 0.02, .toughness = toughness, .height = height, .friction = friction}, .pose = pose});
    double in = 0.0, out = 0.0;
    for (int tick = 0; tick < 1500; ++tick) {
      pose.position.x() += tick < 900 ? -by : by;
      blade.move_to(pose);
      ASSERT_TRUE(sim.advance(1e-3).ok());
      const double force = sim.force_on(blade).mean_force.x();
      if (tick >= 400 && tick < 900) in += force / 500;
      if (tick >= 1100) out -= force / 400;
      if (tick == 1100) {
        EXPECT_GT(sim.force_on(blade).particles, 0);
      }
    }
    EXPECT_NEAR(in / (length * (toughness + friction * height)), 1.0, 0.05);
    EXPECT_NEAR(out / (length * friction * height), 1.0, 0.05);
  }
}

/// The edge has come out by 5 mm on the far side and is drawn back, at last with 17 to 19 mm of the sides in tissue;
/// also after a snapshot.
TEST(Blade, SidesStayInTissueThatTheEdgeHasLeft) {
  constexpr double friction = 1500.0, length = 0.015;
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.02}, 12, 8, 4, 0.25, 7), 900),
                 {.material = {5e4, 0.45, 1000.0}, .backend = "cpu", .damping = {.rate = 20.0}});
  ToolPose pose = Stroke::first(0.005);
  const ToolHandle blade = sim.scene().fix("z0").add_tool(
      "scalpel",
      {.shape = Blade{.width = 0.02, .toughness = 20.0, .height = 0.02, .friction = friction}, .pose = pose});
  const auto go_on = [&](double by, int ticks) {
    double mean = 0.0;
    for (int tick = 0; tick < ticks; ++tick) {
      pose.position.x() += by;
      blade.move_to(pose);
      EXPECT_TRUE(sim.advance(1e-3).ok());
      mean += sim.force_on(blade).mean_force.x() / ticks;
    }
    return mean;
  };
  go_on(-0.1e-3, 670);
  ASSERT_TRUE(std::ranges::none_of(sim.state().tools[0].blade, [](const BladePoint& p) { return p.ahead >= 0.0; }));
  const Snapshot snapshot = sim.snapshot();
  const ToolPose there = pose;
  go_on(0.02e-3, 100);  // until the tissue has gone the other way
  EXPECT_NEAR(go_on(0.02e-3, 100) / (-friction * length * 0.018), 1.0, 0.05);
  const State end = sim.state();
  sim.restore(snapshot);
  pose = there;
  go_on(0.02e-3, 200);
  EXPECT_EQ(sim.state(), end);
}

/// A loop of wire goes along a slab's upper side with its ends above it: what it takes off is a half round, and the
/// force that of its length in tissue. A belly alters neither the cut nor the force.
TEST(Blade, AlongAnArcTakesOffAHalfRound) {
  constexpr double radius = 0.012, above = 0.002, toughness = 20.0, by = 0.1e-3;
  for (const double belly : {0.0, 0.006, -0.004}) {
    if (sanitized && belly != 0.006) continue;
    SCOPED_TRACE(belly);
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.02}, 15, 10, 5, 0.25, 7), 1500),
                   {.material = {2e4, 0.45, 1000.0}, .backend = "cpu", .damping = {.rate = 40.0}});
    sim.scene().fix("z0");
    Mat3 axes;  // along -x, with the ends upward and the middle below them
    axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    ToolPose pose{.position = {0.068, 0.0205, 0.02 + above - radius}, .orientation = Quaternion(axes)};
    const ToolHandle loop = sim.scene().add_tool(
        "loop",
        {.shape = Blade{.width = 2.0 * radius, .toughness = toughness, .belly = belly, .bow = -radius}, .pose = pose});
    std::vector<double> forces;
    for (int tick = 0; tick < 820; ++tick) {
      pose.position.x() -= by;
      loop.move_to(pose);
      const StepReport report = sim.advance(1e-3);
      ASSERT_TRUE(report.ok()) << report.message();
      ASSERT_EQ(report.uncut, 0);
      if (tick > 250 && tick < 550) forces.push_back(sim.force_on(loop).mean_force.x());
    }
    const double below = std::acos(above / radius);  // rad, half of the arc that is in tissue
    const double force = std::accumulate(forces.begin(), forces.end(), 0.0) / static_cast<double>(forces.size());
    const auto pieces = connected_bodies(sim.model());
    ASSERT_GE(pieces.size(), 2u);
    EXPECT_NEAR(force / (toughness * 2.0 * radius * below), 1.0, 0.05);
    const double section = radius * radius * (below - 0.5 * std::sin(2.0 * below));
    EXPECT_NEAR(pieces[1].volume / (0.06 * section), 1.0, 0.05);
    for (std::size_t crumb = 2; crumb < pieces.size(); ++crumb)
      EXPECT_LT(pieces[crumb].volume, 1e-3 * pieces[1].volume);
  }
}

/// A slab is cut by scissors that close around it, where they are strong enough, up to their ends. Each edge cuts ahead
/// of itself by 0.3 spacings and half a cell, so that the work is short of the area's by 0.8 spacings of each way.
TEST(Blade, TwoOnAHingeAreScissors) {
  constexpr double thickness = 0.012, length = 0.024, toughness = 20.0, tick = 1e-3, spacing = 0.003;
  for (const double grip : {2.0, 0.1}) {
    if (sanitized && grip < 1.0) continue;
    Simulation sim(with_spare_particles(make_tetrahedral_block({0.04, 0.03, thickness}, 13, 10, 4, 0.25, 7), 1500),
                   {.material = {1e5, 0.45, 1000.0}, .backend = "cpu", .damping = {.rate = 40.0}});
    sim.scene().fix("y0").fix("y1");
    Mat3 axes;  // into the slab along -x, opening along z, in the plane y = 15.3 mm
    axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    const ToolPose hinge{.position = {0.05, 0.0153, 0.5 * thickness}, .orientation = Quaternion(axes)};
    const double inside = length - 0.01;  // m, of the edges, to x = 26 mm
    Jaws scissors(sim.scene(), "scissors",
                  {.length = length, .grip = grip, .opening = 1.9, .speed = 1.0, .toughness = toughness}, hinge);
    scissors.close();
    double work = 0.0, angle = scissors.angle();
    for (int k = 0; k < 2000; ++k) {
      scissors.follow(hinge, sim.force_on(scissors.first()), sim.force_on(scissors.second()), tick);
      const StepReport report = sim.advance(tick);
      ASSERT_TRUE(report.ok()) << report.message();
      ASSERT_EQ(report.uncut, 0);
      work += length * scissors.grip() * (angle - scissors.angle());
      angle = scissors.angle();
      ASSERT_LT(scissors.force().norm(), 0.3) << k;  // the edges act against each other
    }
    double farthest = 1.0;  // m
    int whole = 0;
    for (const Cell& cell : sim.model().cells) {
      if (cell.share == 0.0) continue;
      const Vec3 at = cell_centre(cell, sim.model().rest);
      if (!cell.cuts.empty()) farthest = std::min(farthest, at.x());
      const auto [low, high] =
          std::ranges::minmax(cell.particles, {}, [&](Index i) { return sim.model().rest[i].y(); });
      const bool crossed = sim.model().rest[low].y() < 0.0145 && sim.model().rest[high].y() > 0.0161;
      if (crossed && cell.cuts.empty() && at.x() > 0.026 + spacing) ++whole;
    }
    if (grip < 1.0) {
      EXPECT_GT(angle, 0.5);
      continue;
    }
    EXPECT_LT(angle, 1e-6);
    EXPECT_EQ(whole, 0);
    EXPECT_NEAR(farthest, 0.026, spacing);
    const double missing = (1.0 - work / (toughness * thickness * inside)) * thickness / spacing;
    EXPECT_GT(missing, 0.0);
    EXPECT_LT(missing, 1.6);
  }
}

/// It reaches the slab after 2 mm.
TEST(Blade, TissueGoesWithADullOne) {
  Stroke stroke("reference", 2000.0);
  double last = 0.0;
  for (int tick = 0; tick < 60; ++tick) {
    ASSERT_TRUE(stroke.go_on(0.1e-3, 2e-3).ok());
    const State now = stroke.sim.state();
    for (const BladePoint& point : now.tools.front().blade) {  // where the way of the edge meets a cell
      for (const double weight : point.weights) EXPECT_GT(weight, -1e-6) << tick;
    }
    if (tick % 10 != 9 || tick < 29) continue;
    const double force = stroke.sim.force_on(stroke.blade).mean_force.x();
    EXPECT_GT(force, last + 0.02) << tick;
    last = force;
  }
  EXPECT_TRUE(stroke.sim.cuts().empty());
  EXPECT_GT(stroke.sim.max_displacement(), 2e-3);
}

/// What the blade gives the body is the force on it, turned round.
TEST(Blade, KeepsMomentum) {
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.04, 0.02}, 9, 6, 3, 0.25, 7), 600),
                 {.material = {1e4, 0.45, 1000.0}, .backend = "reference"});
  ToolPose pose = Stroke::first(0.005);
  const ToolHandle blade = sim.scene().add_tool(
      "scalpel", {.shape = Blade{.width = 0.02, .toughness = 20.0, .height = 0.01, .friction = 1e3}, .pose = pose});
  Vec3 given(0, 0, 0);
  int most = 0;
  const double dt = 0.5 * sim.step_limit();
  for (int tick = 0; tick < 200; ++tick) {
    pose.position.x() -= 0.1e-3;
    blade.move_to(pose);
    ASSERT_TRUE(sim.step(2, dt).ok());
    given -= 2.0 * dt * sim.force_on(blade).mean_force;
    most = std::max(most, sim.force_on(blade).particles);
  }
  ASSERT_FALSE(sim.cuts().empty());
  EXPECT_GT(most, 4);
  EXPECT_LT(given.x(), -1e-4);
  EXPECT_LT((sim.solver().momentum().linear - given).norm(), 1e-10 * given.norm());
}

TEST(Blade, HasTheSameBitsOnAnyNumberOfThreads) {
  Stroke one("cpu", 20.0, 0.005, 1e4, 9, 600, 1, 1e3), two("cpu", 20.0, 0.005, 1e4, 9, 600, 2, 1e3);
  for (int tick = 0; tick < 150; ++tick) {
    one.go_on(0.1e-3);
    two.go_on(0.1e-3);
  }
  ASSERT_FALSE(one.sim.cuts().empty());
  EXPECT_EQ(one.sim.snapshot().state, two.sim.snapshot().state);
}

/// Sizes in micrometres for metres, say: points along the edge and on the sides are limited.
TEST(Blade, OfAnySizeHasRoom) {
  Stroke stroke("cpu");
  stroke.sim.scene().add_tool(
      "large", {.shape = Blade{.width = 2e4, .toughness = 20.0, .height = 1e4, .friction = 1e3}, .pose = stroke.pose});
  EXPECT_TRUE(stroke.go_on(0.5e-3).ok());
}

/// Along faces of cells a cut adds no cell, only copies, for which there is no room here.
TEST(Blade, SaysSoAlongFacesToo) {
  Model model = make_tetrahedral_block({0.06, 0.04, 0.02}, 6, 4, 2, 0.0, 1);
  set_material(model, {5e3, 0.4, 1000.0});
  TopologyTextures topology = build_topology(model);
  BodyEdit edit(model, topology);
  std::vector<Index> cells(model.cells.size());
  std::iota(cells.begin(), cells.end(), 0);
  const CutSurface surface = cut_plane({0.03, 0, 0}, {1, 0, 0});
  const CutPlaces places(model, cells, surface, "test");
  CutCells cut = places.cut();
  std::size_t refused = 0;
  cut.refused = &refused;
  EXPECT_TRUE(edit.find_cut(cut).empty());
  EXPECT_GT(refused, 0u);
}

TEST(Blade, SaysWhatItCannotCut) {
  Stroke stroke("cpu", 0.0, 0.005, 1e4, 9, 3);
  int uncut = 0;
  for (int tick = 0; tick < 60; ++tick) {
    const StepReport report = stroke.go_on(0.5e-3);
    ASSERT_TRUE(report.ok());
    uncut = std::max(uncut, report.uncut);
  }
  EXPECT_GT(uncut, 0);
  Simulation cubes(make_block({0.06, 0.04, 0.02}, 6, 4, 2), options_for("cpu"));
  EXPECT_TRUE(says(message_of([&] { cubes.scene().add_tool("a", {.shape = Blade{.width = 0.01}}); }), "tetrahedra"));
  Scene& scene = stroke.sim.scene();
  EXPECT_TRUE(says(message_of([&] { scene.add_tool("a", {.shape = Blade{}}); }), "expected a width above 0"));
  EXPECT_TRUE(
      says(message_of([&] { scene.add_tool("a", {.shape = Blade{.width = 1, .toughness = -1}}); }), "toughness"));
  const auto refused = [&](const Blade& shape, const char* what) {
    return says(message_of([&] { scene.add_tool("a", {.shape = shape}); }), what);
  };
  EXPECT_TRUE(refused({.width = 1, .belly = 0.6}, "a belly (m) of at most half the width, 0.5, got 0.6"));
  EXPECT_TRUE(refused({.width = 1, .bow = -0.6}, "a bow (m) of at most half the width"));
  EXPECT_TRUE(refused({.width = 1, .height = -1}, "height"));
  EXPECT_TRUE(refused({.width = 1, .friction = -1}, "friction (N/m^2)"));
  EXPECT_TRUE(says(message_of([&] { stroke.blade.grasp(0.01); }), "a blade cannot grasp"));
  EXPECT_TRUE(says(message_of([&] { static_cast<void>(stroke.sim.solve_static()); }), "is a blade"));
}

}  // namespace
}  // namespace phymul
