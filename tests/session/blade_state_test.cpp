// SPDX-License-Identifier: MIT
//
// What a blade does next is determined by the state: also after a teleport, a snapshot, a recording, a cut that was
// undone and a step that failed.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <array>

#include "support/allocation_count.h"
#include "support/cut_bodies.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

/// By more than a spacing in a tick.
TEST(BladeState, AFastOneGoesOnFromASnapshotAsItDid) {
  for (const double toughness : {0.0, 20.0}) {
    Stroke stroke("cpu", toughness, -0.005);
    for (int tick = 0; tick < 2; ++tick) stroke.go_on(0.012);
    const Snapshot half_way = stroke.sim.snapshot();
    const ToolPose pose = stroke.pose;
    const auto go_on = [&] {
      for (int tick = 0; tick < 2; ++tick) stroke.go_on(0.012);
      return stroke.sim.snapshot().state;
    };
    const State end = go_on();
    const BodyCuts cuts = stroke.sim.cuts();
    stroke.sim.restore(half_way);
    stroke.pose = pose;
    EXPECT_EQ(go_on(), end) << toughness;
    EXPECT_TRUE(equal_cuts(stroke.sim.cuts(), cuts)) << toughness;
  }
}

/// From 2 mm before the slab to more than two spacings beyond it; then from there back. With a call without steps
/// between, in which it is not there yet.
TEST(BladeState, ATeleportedOneCutsNothingOnItsWay) {
  for (const int calls_without_steps : {0, 1}) {
    Stroke stroke("cpu", 0.0, -0.005);
    ASSERT_TRUE(stroke.go_on(0.0).ok());
    for (const double x : {-0.02, 0.08}) {
      stroke.pose.position.x() = x;
      stroke.blade.teleport(stroke.pose);
      for (int call = 0; call < calls_without_steps; ++call) ASSERT_TRUE(stroke.sim.advance(0.0).ok());
      ASSERT_TRUE(stroke.sim.advance(1e-3).ok());
      EXPECT_TRUE(stroke.sim.cuts().empty()) << calls_without_steps << ' ' << x;
    }
  }
}

Stroke with_budget(int tick_budget, double toughness = 0.0) {
  return Stroke("cpu", toughness, -0.005, 1e4, 9, 600, 0, 0.0, tick_budget);
}

Index cut_cells(const Simulation& sim) {
  return static_cast<Index>(std::ranges::count_if(sim.model().cells, [](const Cell& c) { return !c.cuts.empty(); }));
}

/// A stroke of 2 cells a tick at the most, which falls behind the blade and catches up while that stands still.
TEST(BladeState, ABudgetBoundsWhatATickCuts) {
  Stroke all = with_budget(0), few = with_budget(2);
  int later = 0;
  for (int tick = 0; tick < 240; ++tick) {
    const double by = tick < 40 ? 1.6e-3 : 0.0;
    EXPECT_EQ(all.go_on(by).cut_later, 0);
    const std::size_t cells = few.sim.model().cells.size(), cuts = few.sim.cuts().size();
    const StepReport report = few.go_on(by);
    ASSERT_TRUE(report.ok());
    later = std::max(later, report.cut_later);
    EXPECT_LE(few.sim.model().cells.size(), cells + 2);
    EXPECT_LE(few.sim.cuts().size(), cuts + 1);
    EXPECT_EQ(report.message().find("tick_budget") != std::string::npos, report.cut_later > 0);
    if (tick == 239) {
      EXPECT_EQ(report.cut_later, 0);
    }
  }
  EXPECT_GT(later, 10);
  const auto pieces = connected_bodies(few.sim.model()), wanted = connected_bodies(all.sim.model());
  ASSERT_EQ(pieces.size(), 2u);
  for (const std::size_t k : {0, 1}) EXPECT_NEAR(pieces[k].volume / wanted[k].volume, 1.0, 0.01);
  EXPECT_TRUE(says(message_of([] { with_budget(-1); }), "tick_budget must be 0 or more cells; got -1"));
}

/// An edge that turns as it goes, and one that tissue holds, in and out: what waits gets the cut where it was passed,
/// and nothing else does.
TEST(BladeState, ABudgetLeavesTheCutWhereItIs) {
  for (const double toughness : {0.0, 20.0, 60.0}) {
    std::array<Index, 2> cells{};
    std::array<std::size_t, 2> pieces{};
    for (const std::size_t bounded : {0, 1}) {
      Stroke stroke = with_budget(bounded != 0 ? 3 : 0, toughness);
      int most_later = 0;
      for (int tick = 0; tick < 200; ++tick) {
        const double turn = toughness == 0.0 && tick < 40 ? 0.01 : 0.0;  // about the way
        const Quaternion by(Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vec3::UnitX())));
        stroke.pose.orientation = by * stroke.pose.orientation;
        const StepReport report = stroke.go_on(tick < 40 ? 0.9e-3 : toughness > 0.0 && tick < 80 ? -0.9e-3 : 0.0);
        ASSERT_TRUE(report.ok());
        EXPECT_EQ(report.uncut, 0);
        most_later = std::max(most_later, report.cut_later);
      }
      EXPECT_EQ(most_later > 0, bounded != 0);
      cells[bounded] = cut_cells(stroke.sim);
      pieces[bounded] = connected_bodies(stroke.sim.model()).size();
    }
    EXPECT_EQ(pieces[1], pieces[0]) << toughness;
    EXPECT_NEAR(cells[1], cells[0], 0.05 * cells[0]) << toughness;
    EXPECT_GT(cells[0], 100);
  }
}

/// Hexahedra, which do not part, in a capsule, which does.
TEST(BladeState, ABudgetLeavesOtherCellsAlone) {
  Model model = make_block({0.06, 0.04, 0.02}, 6, 4, 2);
  set_material(model, {1e4, 0.4, 1000.0});
  add_capsule(model, {.young = 1e5, .poisson = 0.4, .density = 1000.0, .thickness = 5e-4});
  Simulation sim(with_spare_particles(model, 200), {.backend = "cpu", .damping = {.rate = 20.0}, .tick_budget = 2});
  ToolPose pose = Stroke::first(-0.005);
  const ToolHandle blade = sim.scene().fix("z0").add_tool("scalpel", {.shape = Blade{.width = 0.03}, .pose = pose});
  int uncut = 0;
  for (int tick = 0; tick < 30; ++tick) {
    pose.position.x() -= 0.5e-3;
    blade.move_to(pose);
    const StepReport report = sim.advance(1e-4);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report.cut_later, 0);  // no corner of the capsule without a hexahedron
    uncut += report.uncut;
  }
  EXPECT_GT(uncut, 10);
}

TEST(BladeState, WhatABudgetLeavesNeedsNoBlade) {
  Stroke stroke = with_budget(2), all = with_budget(0);
  for (int tick = 0; tick < 12; ++tick) {
    stroke.go_on(1e-3);
    all.go_on(1e-3);
  }
  EXPECT_GT(stroke.sim.advance(0.0).cut_later, 5);
  stroke.sim.scene().remove_tool("scalpel");
  for (int tick = 0; tick < 60; ++tick) ASSERT_TRUE(stroke.sim.advance(1e-3).ok());
  EXPECT_NEAR(cut_cells(stroke.sim), cut_cells(all.sim), 0.05 * cut_cells(all.sim));
}

/// Cells that the edge has passed stay to be cut where it goes elsewhere: here along itself and out.
TEST(BladeState, WhatABudgetLeavesFollowsWhereverTheBladeGoes) {
  Stroke stroke = with_budget(2);
  int first = 0;
  for (int tick = 0; tick < 12; ++tick) first = stroke.go_on(1e-3).cut_later;
  ASSERT_GT(first, 5);
  const std::size_t cuts = stroke.sim.cuts().size();
  for (int tick = 0; tick < 60; ++tick) {
    if (tick < 30) stroke.pose.position.z() += 2e-3;
    ASSERT_TRUE(stroke.go_on(0.0).ok());
  }
  EXPECT_GE(2 * (stroke.sim.cuts().size() - cuts), static_cast<std::size_t>(first));
  EXPECT_EQ(stroke.go_on(0.0).cut_later, 0);
}

TEST(BladeState, WhatABudgetLeavesIsInSnapshotsAndFiles) {
  Stroke stroke = with_budget(3), other = with_budget(3);
  stroke.sim.keep_history(1, 100'000'000);
  for (int tick = 0; tick < 12; ++tick) stroke.go_on(1e-3);
  const std::string path = testing::TempDir() + "budget.state";
  stroke.sim.save(path);
  const Snapshot half_way = stroke.sim.snapshot();
  EXPECT_FALSE(half_way.start.cut_later.empty());
  const ToolPose pose = stroke.pose;
  const auto end_of = [&](Stroke& of) {
    of.pose = pose;
    for (int tick = 0; tick < 12; ++tick) of.go_on(1e-3);
    return of.sim.snapshot();
  };
  const Snapshot end = end_of(stroke);
  stroke.sim.restore(half_way);
  EXPECT_EQ(end_of(stroke), end);
  ASSERT_TRUE(stroke.sim.rewind(half_way.state.time));
  EXPECT_EQ(end_of(stroke), end);
  other.sim.load(path);
  EXPECT_EQ(end_of(other), end);
}

TEST(BladeState, HasNothingThatItGrasps) {
  Stroke stroke("cpu", 0.0, -0.005);
  State state = stroke.sim.state();
  state.tools[0].held = {0};
  state.tools[0].held_at = {Vec3::Zero()};
  EXPECT_TRUE(refuses([&] { stroke.sim.set_state(state); }, "is a blade, which cannot"));
}

TEST(BladeState, AFastOneGoesOnFromARecordingAsItDid) {
  Stroke stroke("cpu", 0.0, -0.005), again("cpu", 0.0, -0.005);
  stroke.sim.record();
  for (int tick = 0; tick < 2; ++tick) stroke.go_on(0.012);
  again.sim.replay(stroke.sim.recording());
  again.blade = again.sim.scene().tool("scalpel");
  again.pose = stroke.pose;
  for (int tick = 0; tick < 2; ++tick) {
    stroke.go_on(0.012);
    again.go_on(0.012);
  }
  EXPECT_EQ(again.sim.state(), stroke.sim.state());
}

/// Each edits the body by itself, so that the last bits depend on how often it was edited.
TEST(BladeState, TwoThatCutInOneCallAreReplayedBitForBit) {
  Stroke stroke("cpu", 20.0, 0.005, 1e4, 9, 1500), again("cpu", 20.0, 0.005, 1e4, 9, 1500);
  Simulation& sim = stroke.sim;
  ToolPose pose = stroke.pose;
  pose.position.y() = 0.012;
  const ToolHandle beside =
      sim.scene().add_tool("beside", {.shape = Blade{.width = 0.02, .toughness = 20.0, .height = 0.01}, .pose = pose});
  sim.record();
  bool both = false;
  for (int tick = 0; tick < 25; ++tick) {
    const std::size_t cuts = sim.cuts().size();
    pose.position.x() -= 0.7e-3;
    beside.move_to(pose);
    ASSERT_TRUE(stroke.go_on(0.7e-3).ok());
    both = both || sim.cuts().size() > cuts + 1;
  }
  EXPECT_TRUE(both);
  again.sim.replay(sim.recording());
  EXPECT_EQ(again.sim.snapshot(), sim.snapshot());
}

/// The blade goes around the slab. The straight line between its first and last place goes through it.
TEST(BladeState, AfterAReplayThatFailsIsWhereThatEnded) {
  Stroke stroke("cpu", 0.0, -0.005), again("cpu", 0.0, -0.005);
  stroke.sim.record();
  for (const Vec3& position : {Vec3(0.062, 0.0205, 0.05), Vec3(-0.02, 0.0205, 0.05), Vec3(-0.02, 0.0205, 0.01)}) {
    stroke.pose.position = position;
    ASSERT_TRUE(stroke.go_on(0.0).ok());
  }
  ASSERT_TRUE(stroke.sim.cuts().empty());
  Recording recording = stroke.sim.recording();
  recording.inputs.push_back({"cuts", "", 1});
  EXPECT_TRUE(refuses([&] { again.sim.replay(recording); }, "Replay: input "));
  ASSERT_TRUE(again.sim.advance(1e-3).ok());
  EXPECT_TRUE(again.sim.cuts().empty());
}

/// Added to a body with a cut, it knows the body without that as well.
TEST(BladeState, OfABodyWithACutFollowsWhenThatIsUndone) {
  Stroke stroke("cpu", 20.0), other("cpu", 20.0);
  const Snapshot start = stroke.sim.snapshot();
  const ToolPose pose = stroke.pose;
  const Tool blade = stroke.sim.scene().tools().front().tool;
  for (int tick = 0; tick < 100; ++tick) stroke.go_on(0.2e-3);
  ASSERT_GT(stroke.sim.model().cells.size(), other.sim.model().cells.size());
  stroke.sim.scene().remove_tool("scalpel");
  ASSERT_TRUE(stroke.sim.advance(1e-3).ok());
  stroke.blade = stroke.sim.scene().add_tool("scalpel", blade);
  ASSERT_TRUE(stroke.sim.advance(1e-3).ok());
  stroke.sim.restore(start);
  stroke.pose = pose;
  for (int tick = 0; tick < 100; ++tick) {
    stroke.go_on(0.2e-3);
    other.go_on(0.2e-3);
  }
  EXPECT_EQ(stroke.sim.state().position, other.sim.state().position);
  EXPECT_TRUE(equal_cuts(stroke.sim.cuts(), other.sim.cuts()));
}

/// Tools of a state: where it is in tissue, as it was told to a simulation that had not found it out itself.
TEST(BladeState, OfItsSidesIsThatWhichWasRestored) {
  const auto make = [] { return Stroke("cpu", 20.0, 0.005, 1e4, 9, 600, 0, 1e3); };
  Stroke stroke = make(), other = make();
  for (int tick = 0; tick < 100; ++tick) stroke.go_on(0.1e-3);
  const Snapshot snapshot = stroke.sim.snapshot();
  const auto& points = snapshot.state.tools.front().blade;
  ASSERT_TRUE(std::ranges::any_of(points, [](const BladePoint& point) { return point.ahead < 0.0; }));
  other.sim.restore(snapshot);
  EXPECT_EQ(other.sim.snapshot().state, snapshot.state);
}

/// In a step that a load makes too large the sides come out of the tissue; that step does not count.
TEST(BladeState, OfItsSidesIsThatBeforeAStepThatFails) {
  Stroke stroke("cpu", 20.0, 0.005, 1e4, 9, 600, 0, 1e3);
  for (int tick = 0; tick < 100; ++tick) stroke.go_on(0.1e-3);
  const State before = stroke.sim.snapshot().state;
  stroke.sim.scene().gravity({0, 0, 1e12});
  ASSERT_FALSE(stroke.sim.step(1, stroke.sim.step_limit()).ok());
  EXPECT_EQ(stroke.sim.snapshot().state.tools.front().blade, before.tools.front().blade);
}

TEST(BladeState, WhatItHasJustCutIsNotAtRest) {
  Stroke stroke("cpu", 0.0, -0.005, 1e4, 6);
  ASSERT_TRUE(stroke.sim.run_to_rest().converged());
  stroke.pose.position.x() -= 0.02;
  stroke.blade.move_to(stroke.pose);
  const RestResult result = stroke.sim.run_to_rest();
  EXPECT_FALSE(stroke.sim.cuts().empty());
  EXPECT_FALSE(result.converged() || result.report.at_rest);
  EXPECT_TRUE(stroke.sim.run_to_rest().converged());
}

/// Where parts have local steps without substeps, the solver keeps its body.
TEST(BladeState, CutsNothingBesideAPartWithSmallCells) {
  Model fine = make_tetrahedral_block({0.002, 0.002, 0.002}, 2, 2, 2, 0.25, 7);
  for (Vec3& place : fine.rest) place.x() += 0.2;
  std::vector<SimulationBody> bodies{{.name = "fine", .model = fine}};
  const Model coarse = make_tetrahedral_block({0.06, 0.04, 0.02}, 15, 10, 5, 0.25, 7);
  bodies.push_back({.name = "coarse", .model = with_spare_particles(coarse, 900)});
  SimulationOptions options{.material = {1e4, 0.45, 1000.0}, .backend = "cpu"};
  options.solver.max_substeps = 8;
  Simulation sim(std::move(bodies), options);
  ToolPose pose = Stroke::first(-0.005);
  const ToolHandle blade = sim.scene().add_tool("scalpel", {.shape = Blade{.width = 0.03}, .pose = pose});
  ASSERT_EQ(sim.solver().substeps(), 1);
  int uncut = 0;
  for (int tick = 0; tick < 10; ++tick) {
    pose.position.x() -= 1e-3;
    blade.move_to(pose);
    const StepReport report = sim.advance(1e-5);
    uncut += report.uncut;
    EXPECT_EQ(report.message().find(" could not part: ") != std::string::npos, report.uncut > 0);
  }
  EXPECT_GT(uncut, 100);
  EXPECT_TRUE(sim.cuts().empty());
}

/// What the first cut needs is there after a call of no time, before a loop that must not pause.
TEST(BladeState, ACallOfNoTimePreparesTheFirstCut) {
  const Model model = make_tetrahedral_block({0.06, 0.04, 0.02}, 12, 8, 4, 0.25, 7);
  Simulation sim(with_spare_particles(model, 100), {.material = {1e4, 0.45, 1000.0}, .backend = "cpu"});
  ASSERT_TRUE(sim.advance(1e-3).ok());
  sim.scene().add_tool("scalpel", {.shape = Blade{.width = 0.03}, .pose = Stroke::first(-0.005)});
  sim.advance(0.0);
  const std::size_t before = allocation_count();
  ASSERT_TRUE(sim.advance(1e-3).ok());
  EXPECT_LT(allocation_count() - before, model.rest.size() / 2) << "it lists the cells of each particle";
}

/// A spacing is that of all bodies: here an eighth of the coarse one's edges. The blade goes through its side's middle,
/// far from all particles.
TEST(BladeState, CutsACoarseBodyBesideAFineOneToo) {
  const auto cut_cells = [](bool beside) {
    std::vector<SimulationBody> bodies;
    if (beside) {
      Model fine = make_tetrahedral_block({0.02, 0.02, 0.02}, 14, 14, 14, 0.25, 7);
      for (Vec3& place : fine.rest) place.x() += 0.2;
      bodies.push_back({.name = "fine", .model = fine});
    }
    const Model coarse = make_tetrahedral_block({0.06, 0.04, 0.02}, 3, 2, 1, 0.25, 7);
    bodies.push_back({.name = "coarse", .model = with_spare_particles(coarse, 100)});
    Simulation sim(std::move(bodies), {.material = {1e4, 0.45, 1000.0}, .backend = "cpu"});
    ToolPose pose = Stroke::first(-0.005);
    const ToolHandle blade = sim.scene().add_tool("scalpel", {.shape = Blade{.width = 0.004}, .pose = pose});
    for (int tick = 0; tick < 140; ++tick) {
      pose.position.x() -= 0.5e-3;
      blade.move_to(pose);
      EXPECT_TRUE(sim.advance(1e-5).ok());
    }
    return std::ranges::count_if(sim.model().cells, [](const Cell& cell) { return !cell.cuts.empty(); });
  };
  const auto alone = cut_cells(false);
  EXPECT_GT(alone, 0);
  EXPECT_EQ(cut_cells(true), alone);
}

/// Whatever body comes first in the model.
TEST(BladeState, IsHeldByABodyBesideOneWithACut) {
  Model slab = make_tetrahedral_block({0.06, 0.04, 0.02}, 6, 4, 2, 0.25, 7);
  set_material(slab, {1e4, 0.45, 1000.0});
  const Model cut = cut_body(moved(slab, {0, 0.1, 0}), cut_plane({0.03, 0.12, 0.01}, {1, 0, 0}));
  std::array<double, 2> force{};  // N
  for (const std::size_t first : {0, 1}) {
    const std::array<NamedBody, 2> bodies{{{"first", first == 0 ? &slab : &cut}, {"last", first == 0 ? &cut : &slab}}};
    Simulation sim(with_spare_particles(merge_models(bodies), 200), {.backend = "cpu", .damping = {.rate = 20.0}});
    sim.scene().fix("first/z0").fix("last/z0");
    ToolPose pose = Stroke::first(-0.005);
    const ToolHandle blade = sim.scene().add_tool(
        "scalpel", {.shape = Blade{.width = 0.03, .toughness = 20.0, .height = 0.01}, .pose = pose});
    for (int tick = 0; tick < 20; ++tick) {
      pose.position.x() -= 0.3e-3;
      blade.move_to(pose);
      ASSERT_TRUE(sim.advance(1e-3).ok());
    }
    force[first] = sim.force_on(blade).mean_force.norm();
  }
  EXPECT_GT(force[0], 0.1);
  EXPECT_NEAR(force[1] / force[0], 1.0, 0.01);
}

}  // namespace
}  // namespace phymul
