// SPDX-License-Identifier: MIT
//
// What a simulation is asked between two steps, where states are set, read or refused before the next one.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "model/cell_geometry.h"
#include "support/cut_bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr Material asked_tissue{.young = 1e4, .poisson = 0.3, .density = 1000.0};
const ToolPose above_cube{.position = {0.02, 0.02, 0.045}}, far_above_cube{.position = {0.02, 0.02, 0.2}};

Simulation held_cube(const std::string& backend = "reference", int n = 4) {
  Simulation sim(make_tetrahedral_block({0.04, 0.04, 0.04}, n, n, n, 0.2, 3),
                 {.material = asked_tissue, .backend = backend, .damping = {.rate = 20.0}});
  sim.scene().fix("z0");
  return sim;
}

/// A state of another body.
void restore_what_does_not_fit(Simulation& sim) {
  EXPECT_TRUE(refuses([&] { sim.restore(held_cube("reference", 3).snapshot()); }, "expected"));
}

/// All of which make the solver, or give it a state, before the next step.
const std::vector<std::function<void(Simulation&)>> before_steps{[](Simulation& sim) { (void)sim.warnings(); },
                                                                 [](Simulation& sim) { sim.set_state(sim.state()); },
                                                                 restore_what_does_not_fit};

class AskedBetweenStepsOn : public OnEveryBackend {};
PHYMUL_ON_BACKENDS(AskedBetweenStepsOn, (std::vector<std::string>{"reference", "cpu"}));

TEST_P(AskedBetweenStepsOn, AStateSaysHowMuchFluidThereIs) {
  Simulation sim = held_cube(GetParam());
  sim.scene().constrain_volume();
  const VolumeConstraint whole = sim.scene().volume_constraints()[0];
  const Snapshot start = sim.snapshot();
  sim.scene().set_volume(whole.name, 1.02 * whole.volume);
  ASSERT_TRUE(sim.advance(1e-3).ok());
  sim.restore(start);
  EXPECT_EQ(sim.solver().fluid(whole.name).volume, whole.volume);
  EXPECT_EQ(sim.snapshot(), start);
}

/// Its pressures are below 0, as of what begins anew, which is -0.
TEST_P(AskedBetweenStepsOn, AGasBelowTheOuterPressureIsRestored) {
  Simulation sim = held_cube(GetParam());
  sim.scene().constrain_volume();
  const VolumeConstraint whole = sim.scene().volume_constraints()[0];
  Fluid gas;
  gas.law = FluidLaw::gas;
  gas.outer_pressure = 1000.0;
  sim.scene().set_fluid(whole.name, gas).set_volume(whole.name, 0.9 * whole.volume);
  ASSERT_TRUE(sim.step(20, 1e-4).ok());
  ASSERT_LT(sim.solver().fluid(whole.name).pressure, 0.0);
  const Snapshot there = sim.snapshot();
  ASSERT_TRUE(sim.step(20, 1e-4).ok());
  const Snapshot later = sim.snapshot();
  sim.restore(there);
  EXPECT_EQ(sim.snapshot(), there);
  ASSERT_TRUE(sim.step(20, 1e-4).ok());
  EXPECT_EQ(sim.snapshot(), later);
}

TEST_P(AskedBetweenStepsOn, AVolumeIsTheOneThatWasSet) {
  for (std::size_t kind = 0; kind < before_steps.size(); ++kind) {
    Simulation sim = held_cube(GetParam());
    sim.scene().constrain_volume();
    const VolumeConstraint whole = sim.scene().volume_constraints()[0];
    const auto set = [&] { sim.scene().set_volume(whole.name, 1.02 * whole.volume); };
    if (kind == 2) set();  // what is refused comes after
    before_steps[kind](sim);
    if (kind != 2) set();
    EXPECT_NEAR(sim.state().fluids.at(0).volume, 1.02 * whole.volume, 1e-12 * whole.volume) << kind;
    ASSERT_TRUE(sim.advance(1e-3).ok());
    EXPECT_NEAR(sim.solver().fluid(whole.name).volume, 1.02 * whole.volume, 1e-6 * whole.volume) << kind;
  }
}

/// m, between the passages of a clip that is drawn to 2 mm.
double closed_gap(std::size_t kind) {
  Simulation sim = held_cube();
  const auto top = [&](double x) {
    return at_mean(sim.model().particles_in([&](const Vec3& place) {
      return std::abs(place.x() - x) < 0.007 && place.z() > 0.039 && std::abs(place.y() - 0.02) < 0.012;
    }));
  };
  const ThreadHandle clip = sim.scene().add_clip("clip", {.gap = 8e-3, .holding = 5.0}, top(0.013), top(0.027));
  EXPECT_TRUE(sim.advance(2e-3).ok());
  if (kind == 1) sim.set_state(sim.state());
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) clip.clamp(tip, 5.0, 2e-3);
  if (kind == 2) restore_what_does_not_fit(sim);
  if (kind == 3) sim.restore(sim.snapshot());
  EXPECT_TRUE(sim.advance(2e-3).ok());
  return sim.solver().thread_state(clip).rest_length.at(1);
}

TEST(AskedBetweenSteps, AClipClosesAgain) {
  for (std::size_t kind = 0; kind < 4; ++kind) EXPECT_NEAR(closed_gap(kind), 2e-3, 1e-9) << kind;
}

/// What was removed has left nothing to what now has its name.
TEST_P(AskedBetweenStepsOn, WhatIsAddedAgainBeginsAnew) {
  Simulation sim = held_cube(GetParam());
  Scene& scene = sim.scene();
  scene.constrain_volume();
  VolumeConstraint kept = scene.volume_constraints()[0];
  scene.add_tool("hand", {.shape = Sphere{5e-3}, .pose = above_cube}).grasp(4e-3);
  scene.add_thread("thread", {.length = 0.02}, {0, 0, 0.2}, {1, 0, 0});
  ASSERT_TRUE(sim.advance(1e-3).ok());
  ASSERT_GT(sim.solver().held("hand"), 0);
  scene.remove_tool("hand");
  const ToolHandle hand = scene.add_tool("hand", {.shape = Sphere{5e-3}, .pose = far_above_cube});
  scene.remove_thread("thread");
  const ThreadHandle thread = scene.add_thread("thread", {.length = 0.02}, {0, 0, 0.4}, {1, 0, 0});
  scene.remove_volume(kept.name);
  kept.volume *= 1.01;
  scene.constrain_volume(kept);
  const State state = sim.state();
  EXPECT_TRUE(state.tools.empty() && state.threads.empty());
  for (const bool whole : {true, false}) {
    whole ? sim.restore(sim.snapshot()) : sim.set_state(state);
    EXPECT_EQ(sim.solver().held(hand), 0);
    EXPECT_EQ(sim.pose_of(hand).position.z(), 0.2);
    EXPECT_EQ(sim.solver().thread_state(thread).position[0].z(), 0.4);
  }
  ASSERT_TRUE(sim.advance(1e-3).ok());
  EXPECT_EQ(sim.solver().held(hand), 0);
  EXPECT_NEAR(sim.solver().fluid(kept.name).volume, kept.volume, 1e-6 * kept.volume);
}

TEST(AskedBetweenSteps, ANewToolMovesNoBodyAtRest) {
  Simulation sim = held_cube();
  sim.scene().add_tool("hand", {.shape = Sphere{5e-3}, .pose = above_cube}).grasp(4e-3);
  ASSERT_TRUE(sim.advance(1e-3).ok());
  ASSERT_GT(sim.solver().held("hand"), 0);
  sim.scene().remove_tool("hand");
  sim.scene().add_tool("hand", {.shape = Sphere{5e-3}, .pose = far_above_cube});
  ASSERT_TRUE(sim.solve_static().converged());
  EXPECT_LT(sim.max_displacement(), 1e-6);
}

/// Whether nothing of the state was taken over, or the solver refuses it after its tools were.
TEST(AskedBetweenSteps, ToolsDoWhatWasAskedBeforeAStateThatIsRefused) {
  for (const bool damaged : {false, true}) {
    Simulation sim = held_cube();
    const ToolHandle hand = sim.scene().add_tool("hand", {.shape = Sphere{5e-3}, .pose = above_cube});
    ASSERT_TRUE(sim.advance(1e-3).ok());
    Snapshot other = sim.snapshot();
    other.last_dt = -1.0;
    const ToolPose above{.position = {0.02, 0.02, 0.046}};
    hand.grasp(4e-3);
    hand.move_to(above);
    if (damaged) {
      EXPECT_TRUE(refuses([&] { sim.restore(other); }, "expected a finite last step"));
    } else {
      restore_what_does_not_fit(sim);
    }
    ASSERT_TRUE(sim.advance(1e-3).ok());
    EXPECT_GT(sim.solver().held(hand), 0) << damaged;
    EXPECT_EQ(sim.pose_of(hand), above) << damaged;
  }
}

/// Whether a knot that broke is tied anew, over the ways that lead there.
void tie_again(std::size_t kind) {
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.2, 3), 100),
                 {.material = asked_tissue, .backend = "reference"});
  const ThreadHandle thread = sim.scene().fix("x0").sew("s", {}, VecList{{0.01, 0.01, 0.02}, {0.03, 0.01, 0.02}});
  thread.tie(0, 1, 1);
  ASSERT_TRUE(sim.step(1, 1e-4).ok());
  State broken = sim.state();
  KnotState& knot = broken.threads[0].knots.at(0);
  const double apart = knot.rest_length;
  knot = {.a = 0, .b = 1, .rest_length = 2.0 * apart, .broken = true};
  sim.set_state(broken);
  thread.tie(0, 1, 1);
  if (kind == 1) {
    ASSERT_TRUE(sim.cut(cut_plane({0.02, 0, 0.0102}, {0, 0, 1})));
  }
  if (kind == 2) sim.restore(sim.snapshot());
  if (kind == 3) sim.set_state(sim.state());
  if (kind == 4) sim.record();
  ASSERT_TRUE(sim.step(1, kind == 5 ? 2e-5 : 1e-4).ok());
  const KnotState& now = sim.solver().thread_state(thread).knots.at(0);
  EXPECT_TRUE(!now.broken && std::abs(now.rest_length - apart) < 1e-3 * apart) << kind;
}

TEST(AskedBetweenSteps, AKnotThatBrokeIsTiedAgain) {
  for (std::size_t kind = 0; kind < 6; ++kind) tie_again(kind);
}

/// Particles that it holds have lost cells.
TEST_P(AskedBetweenStepsOn, AToolWeighsWhatIsLeftOfWhatItHolds) {
  Simulation sim = held_cube(GetParam());
  const ToolHandle hand = sim.scene().add_tool("hand", {.shape = Sphere{5e-3}, .pose = above_cube});
  hand.grasp(8e-3);
  ASSERT_TRUE(sim.advance(1e-3).ok());
  const double before = sim.force_on(hand).held_mass;
  const Index first = sim.state().tools.at(0).held.at(0);
  const auto has_it = [&](const Cell& cell) { return std::ranges::count(cell.particles, first) > 0; };
  const std::vector<Cell>& cells = sim.model().cells;
  sim.remove_cells(std::vector{static_cast<Index>(std::ranges::find_if(cells, has_it) - cells.begin())});
  const std::vector<Index> held = sim.state().tools.at(0).held;
  double mass = 0.0;
  for (const Index i : held) mass += sim.model().mass[i];
  EXPECT_LT(mass, 0.999 * before);
  EXPECT_NEAR(sim.force_on(hand).held_mass, mass, 1e-12 * mass);
}

TEST_P(AskedBetweenStepsOn, ACallWithoutStepsFindsNoStrain) {
  Simulation sim = held_cube(GetParam());
  State wide = sim.state();
  for (Vec3& place : wide.position) place.x() *= 1.3;
  sim.set_state(wide);
  EXPECT_EQ(sim.step(0, 1e-4).growth, 0.0);
  EXPECT_GT(sim.step(1, 1e-5).growth, 1.0);
}

/// Cells that a blade has passed, and that still wait for their cuts, are of the body, as its cuts are.
TEST(AskedBetweenSteps, WhatABudgetLeavesStays) {
  for (const bool at_rest : {false, true}) {
    Stroke stroke("cpu", 0.0, -0.005, 1e4, 9, 600, 0, 0.0, 2);
    for (int tick = 0; tick < 12; ++tick) stroke.go_on(1e-3);
    stroke.sim.scene().remove_tool("scalpel");
    const int later = stroke.sim.advance(0.0).cut_later;
    ASSERT_GT(later, 5);
    if (at_rest) {
      ASSERT_TRUE(stroke.sim.solve_static().converged());
    } else {
      stroke.sim.set_state(stroke.sim.state());
    }
    EXPECT_EQ(stroke.sim.advance(0.0).cut_later, later) << at_rest;
    EXPECT_EQ(stroke.sim.step(1, 0.3 * stroke.sim.step_limit()).cut_later, later - 2) << at_rest;
  }
}

/// Cell 40 is parted by two other cuts while it waits: in two parts, then four.
TEST(AskedBetweenSteps, WhatWaitsForItsCutDoesSoInAllItsParts) {
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.2, 3), 200),
                 {.material = asked_tissue, .backend = "reference", .tick_budget = 1});
  Snapshot start = sim.snapshot();
  start.start.cut_later = {{.cell = 0, .cut = {1.0, 1.0, 1.0, 1.0}}, {.cell = 40, .cut = {-1e-3, 1e-3, 1e-3, 1e-3}}};
  sim.restore(start);
  const Vec3 centre = cell_centre(sim.model().cells[40], sim.model().rest);
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 1, 0)}) {
    std::vector<Snapshot::CutLater> wanted = sim.snapshot().start.cut_later;
    const auto row = static_cast<Index>(sim.model().cells.size());
    ASSERT_TRUE(sim.cut(cut_plane(centre, normal)));
    const std::vector<BodyCut::Added>& added = sim.cuts().back()->added;
    const std::vector<Snapshot::CutLater> before = wanted;
    for (std::size_t k = 0; k < added.size(); ++k) {
      const auto of = std::ranges::find(before, added[k].of, &Snapshot::CutLater::cell);
      if (of != before.end()) wanted.push_back({row + static_cast<Index>(k), of->cut});
    }
    EXPECT_EQ(wanted.size(), 2 * before.size() - 1);
    EXPECT_EQ(sim.snapshot().start.cut_later, wanted);
  }
}

/// After steps, and where a state was given after the last of them; also a recording that was looked at before.
TEST(AskedBetweenSteps, WhatABudgetLeavesIsAtTheEndOfAReplay) {
  for (const bool given : {false, true}) {
    Stroke stroke("cpu", 0.0, -0.005, 1e4, 9, 600, 0, 0.0, 2), again("cpu", 0.0, -0.005, 1e4, 9, 600, 0, 0.0, 2);
    stroke.sim.record();
    for (int tick = 0; tick < 12; ++tick) {
      stroke.go_on(1e-3);
      if (tick > 5) stroke.sim.recording();
    }
    if (given) stroke.sim.restore(stroke.sim.snapshot());
    Recording damaged = stroke.sim.recording();
    again.sim.replay(damaged);
    ASSERT_GT(again.sim.snapshot().start.cut_later.size(), 5u) << given;
    EXPECT_EQ(again.sim.snapshot(), stroke.sim.snapshot()) << given;
    for (Stroke* const of : {&stroke, &again}) {
      for (int tick = 0; tick < 30; ++tick) ASSERT_TRUE(of->sim.advance(1e-3).ok());
    }
    EXPECT_EQ(again.sim.snapshot(), stroke.sim.snapshot()) << given;
    Simulation third = std::move(Stroke("cpu", 0.0, -0.005, 1e4, 9, 600, 0, 0.0, 2).sim);
    third.replay(stroke.sim.recording());
    EXPECT_EQ(third.snapshot(), stroke.sim.snapshot()) << "none that waited before";
    ASSERT_EQ(damaged.inputs.back().kind, "late");
    damaged.inputs.back().bytes.resize(20);
    const Snapshot before = third.snapshot();
    EXPECT_THROW(third.replay(damaged), Error);
    EXPECT_EQ(third.snapshot(), before) << "it is refused at its start";
  }
}

/// Of tetrahedra but for hexahedra from x = 30 to 35 mm, which do not part, nor does what touches them. The blade goes
/// through all of it, and what waits behind them in line gets its cut.
TEST(AskedBetweenSteps, WhatCannotPartKeepsNobodyWaiting) {
  Model model = make_block({0.06, 0.04, 0.02}, 12, 8, 4);
  for (std::size_t row = model.cells.size(); row-- > 0;) {
    const Cell whole = model.cells[row];
    if (std::abs(cell_centre(whole, model.rest).x() - 0.0325) < 1e-3) continue;
    constexpr std::array<std::array<int, 2>, 6> around{{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}}};
    for (const auto& [a, b] : around) {
      Cell& part = a == 1 ? model.cells[row] : model.cells.emplace_back(whole);
      part.type = CellType::tetrahedron;
      part.particles = {whole.particles[0], whole.particles[a], whole.particles[b], whole.particles[6]};
    }
  }
  std::array<Index, 2> cut{};
  for (const std::size_t bounded : {0, 1}) {
    Simulation sim(with_spare_particles(model, 900),
                   {.material = asked_tissue, .backend = "cpu", .tick_budget = bounded != 0 ? 4 : 0});
    ToolPose pose = Stroke::first(-0.005);
    const ToolHandle blade = sim.scene().add_tool("scalpel", {.shape = Blade{.width = 0.03}, .pose = pose});
    for (int tick = 0; tick < 150; ++tick) {
      if (tick < 19) pose.position.x() -= 4e-3;
      blade.move_to(pose);
      ASSERT_TRUE(sim.advance(1e-4).ok());
    }
    cut[bounded] =
        static_cast<Index>(std::ranges::count_if(sim.model().cells, [](const Cell& c) { return !c.cuts.empty(); }));
  }
  EXPECT_GT(cut[0], 200);
  EXPECT_NEAR(cut[1], cut[0], 0.02 * cut[0]);
}

/// Of two cells the first does not part any more.
TEST(AskedBetweenSteps, NothingRestsWhileACellWaits) {
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.2, 3), 100),
                 {.material = asked_tissue, .backend = "reference", .tick_budget = 1});
  sim.scene().fix("z0");
  Snapshot start = sim.snapshot();
  start.start.cut_later = {{.cell = 0, .cut = {1.0, 1.0, 1.0, 1.0}}, {.cell = 40, .cut = {-1e-3, 1e-3, 1e-3, 1e-3}}};
  sim.restore(start);
  EXPECT_TRUE(sim.run_to_rest(20'000).converged());
  EXPECT_EQ(sim.cuts().size(), 1u);
  EXPECT_EQ(sim.advance(0.0).cut_later, 0);
}

}  // namespace
}  // namespace phymul::test
