// SPDX-License-Identifier: MIT
//
// Blades: what they cut, with which force, and that every backend, snapshots and recordings have them.
#include <gtest/gtest.h>
#include <phymul/bodies.h>
#include <phymul/monitor.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <numeric>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/removable_body.h"

namespace phymul {
namespace {

using namespace test;

/// A slab of 60 x 40 x 20 mm on its lower face, and a blade that goes into it along -x in the plane y = 20.5 mm, with
/// its edge along z.
struct Stroke {
  Simulation sim;
  ToolHandle blade;
  ToolPose pose;

  Stroke(const std::string& backend, double toughness, double lowest = 0.005, double young = 1e4, int across = 9,
         Index spare = 600, int threads = 0)
      : sim(with_spare_particles(
                make_tetrahedral_block({0.06, 0.04, 0.02}, across, across * 2 / 3, across / 3, 0.25, 7), spare),
            {.material = {young, 0.45, 1000.0},
             .backend = backend,
             .damping = {.rate = 20.0},
             .solver = {.threads = threads}}),
        blade(sim.scene().fix("z0").add_tool(
            "scalpel", {.shape = Blade{.width = 0.025 - lowest, .toughness = toughness}, .pose = first(lowest)})),
        pose(first(lowest)) {}

  static ToolPose first(double lowest) {
    Mat3 axes;
    axes << 0, 0, 1, 0, 1, 0, 1, 0, 0;
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return {.position = {0.062, 0.0205, 0.5 * (0.025 + lowest)}, .orientation = Quaternion(Eigen::Quaterniond(axes))};
  }

  StepReport go_on(double by, double seconds = 1e-3) {
    pose.position.x() -= by;
    blade.move_to(pose);
    return sim.advance(seconds);
  }
};

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

TEST_P(BladeOn, GoesOnFromASnapshotAndIsRecorded) {
  Stroke stroke(GetParam(), 20.0), other(GetParam(), 20.0);
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

  Stroke again(GetParam(), 20.0);
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
  const ToolHandle blade =
      sim.scene().add_tool("scalpel", {.shape = Blade{.width = 0.02, .toughness = 20.0}, .pose = pose});
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
  Stroke one("cpu", 20.0, 0.005, 1e4, 9, 600, 1), two("cpu", 20.0, 0.005, 1e4, 9, 600, 2);
  for (int tick = 0; tick < 150; ++tick) {
    one.go_on(0.1e-3);
    two.go_on(0.1e-3);
  }
  ASSERT_FALSE(one.sim.cuts().empty());
  EXPECT_EQ(one.sim.snapshot().state, two.sim.snapshot().state);
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
  EXPECT_TRUE(says(message_of([&] { stroke.blade.grasp(0.01); }), "a blade cannot grasp"));
  EXPECT_TRUE(says(message_of([&] { static_cast<void>(stroke.sim.solve_static()); }), "is a blade"));
}

}  // namespace
}  // namespace phymul
