// SPDX-License-Identifier: MIT
//
// What of a scene follows Simulation::remove_cells: contacts, tools, joints, volumes, loads.
#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>

#include "support/cut_bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

class RemovedCellsOn : public OnEveryBackend {};

/// The two halves of a block, parted by a layer without cells, fall apart and land on each other again.
TEST_P(RemovedCellsOn, BareSurfacesThatTouch) {
  Simulation sim(make_block({0.03, 0.03, 0.06}, 3, 3, 6), options_for(GetParam()));
  sim.scene().fix("z0").gravity({0, 0, -9.81}).contacts({});
  ASSERT_EQ(connected_bodies(sim.model()).size(), 1u);
  std::vector<Index> layer;
  for (Index row = 0; row < static_cast<Index>(sim.model().cells.size()); ++row) {
    double low = 1.0;
    for (const Index i : sim.model().cells[row].particles) low = std::min(low, sim.model().rest[i].z());
    if (std::abs(low - 0.03) < 1e-6) layer.push_back(row);
  }
  ASSERT_EQ(layer.size(), 9u);
  ASSERT_TRUE(sim.advance(0.001).ok());  // a solver made later would see the surfaces as they are then
  sim.remove_cells(layer);
  const std::vector<ConnectedBody> pieces = connected_bodies(sim.model());
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].cells.size(), 27u);
  EXPECT_NEAR(pieces[1].volume, 0.03 * 0.03 * 0.02, 1e-15);
  ASSERT_TRUE(sim.advance(0.4).ok());
  const State state = sim.solver().read();
  double below = 0.0, above = 1.0;
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    if (sim.model().rest[i].z() < 0.031) below = std::max(below, state.position[i].z());
    if (sim.model().rest[i].z() > 0.039) above = std::min(above, state.position[i].z());
  }
  EXPECT_LT(above, 0.036);         // it fell
  EXPECT_GT(above, below - 2e-3);  // and lies on the lower half
  sim.remove_cells(pieces[1].cells);
  EXPECT_EQ(connected_bodies(sim.model()).size(), 1u);
  EXPECT_TRUE(sim.advance(0.05).ok());
}

/// What tools are asked before a cut, a removal or an undo of one, they do in the step after it.
TEST_P(RemovedCellsOn, LetToolsDoWhatTheyWereAskedBefore) {
  const CutSurface plane = cut_plane({0.03, 0, 0}, {1, 0.1, 0});
  const std::vector<std::function<void(ToolHandle, ToolHandle)>> asks{
      [](ToolHandle ball, ToolHandle) {
        ball.move_to({.position = {0.045, 0.02, 0.031}});
      },
      [](ToolHandle ball, ToolHandle) {
        ball.teleport({.position = {0.02, 0.02, 0.032}});
      },
      [](ToolHandle, ToolHandle hook) { hook.grasp(1e-3); }, [](ToolHandle, ToolHandle hook) { hook.release(); },
      [](ToolHandle, ToolHandle hook) {
        hook.release();
        hook.grasp(1e-3);
      }};
  for (std::size_t k = 0; k < asks.size(); ++k) {
    std::vector<State> ends;
    for (const bool before : {false, true}) {
      Simulation sim(with_spare_particles(slab(), 300), options_for(GetParam()));
      sim.scene().fix("x0").gravity({0, 0, -1.0});
      const ToolHandle ball = sim.scene().add_tool({.shape = Sphere{4e-3}, .pose = {.position = {0.045, 0.02, 0.035}}});
      const ToolHandle hook = sim.scene().add_tool({.shape = Sphere{3e-3}, .pose = {.position = {0.06, 0.02, 0.01}}});
      if (k >= 3) hook.grasp(8e-3);
      sim.step(2, 1e-4);
      if (before) asks[k](ball, hook);
      ASSERT_TRUE(sim.cut(plane));
      if (!before) asks[k](ball, hook);
      sim.step(2, 1e-4);
      ends.push_back(sim.solver().read());
    }
    EXPECT_EQ(ends[1].tools, ends[0].tools) << k;
    EXPECT_EQ(ends[1].position, ends[0].position) << k;
  }
}

/// A cut leaves the mass, save what light particles beside both need so as not to vibrate faster.
TEST(RemovedCells, AreNotBroughtBackByACut) {
  Simulation sim(with_spare_particles(slab(), 400), options_for("reference"));
  std::mt19937 bits(1);
  std::vector<Index> some;
  for (Index row = 0; row < static_cast<Index>(sim.model().cells.size()); ++row) {
    if (bits() % 3 == 0) some.push_back(row);
  }
  sim.remove_cells(some);
  const auto mass = [&] { return std::accumulate(sim.model().mass.begin(), sim.model().mass.end(), 0.0); };
  const double before = mass();
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1})));
  EXPECT_NEAR(mass(), before, 0.02 * before);
}

/// So that a hand that feels the tool feels no gap in the ticks in which tissue parts.
TEST_P(RemovedCellsOn, LeaveWhatToolsFeel) {
  Simulation sim(slab(), options_for(GetParam()));
  sim.scene().fix("z0");
  const ToolHandle ball = sim.scene().add_tool(
      {.shape = Sphere{8e-3}, .pose = {.position = {0.03, 0.02, 0.0355}}, .contact = ToolContact::surface});
  ASSERT_TRUE(sim.step(20, 2e-4).ok());
  ball.move_to({.position = {0.03, 0.02, 0.0345}});
  ASSERT_TRUE(sim.step(5, 2e-4).ok());
  const ToolForce felt = sim.force_on(ball);
  const State before = sim.state();
  EXPECT_GT(felt.force.norm(), 1e-3);
  sim.remove_cells(std::vector<Index>{3});
  EXPECT_EQ(sim.force_on(ball), felt);
  EXPECT_LT(largest_distance(sim.state().velocity, before.velocity), 2e-4);
}

TEST(RemovedCells, ArePickedWhereTheyAreNow) {
  Simulation sim(slab(), options_for("reference"));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.1).ok());
  const VecList now = sim.solver().read().position;
  const auto low = [](const Vec3& x) { return x.z() < -0.005; };
  EXPECT_TRUE(sim.model().cells_in(low).empty());
  const std::vector<Index> hanging = sim.model().cells_in(low, now);
  EXPECT_FALSE(hanging.empty());
  sim.remove_cells(hanging);
  EXPECT_TRUE(sim.model().cells_in(low, now).empty());
  EXPECT_TRUE(refuses([&] { static_cast<void>(sim.model().cells_in(low, VecList(3))); }, "got 3"));
}

TEST_P(RemovedCellsOn, ReleaseToolsAndJoints) {
  Simulation sim(slab(), options_for(GetParam()));
  const Model& model = sim.model();
  sim.scene().fix("x0");
  const Vec3 corner(0.06, 0.04, 0.03);
  Index at = 0;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if ((model.rest[i] - corner).norm() < (model.rest[at] - corner).norm()) at = i;
  }
  Joint joint;
  joint.stiffness = 1.0;
  joint.springs.push_back({.a = {.particles = {at}, .weights = {1.0}}, .b = at_world(corner + Vec3(0.02, 0, 0))});
  joint.springs.push_back({.a = {.particles = {0}, .weights = {1.0}}, .b = at_world(Vec3(-0.01, 0, 0))});
  const JointHandle held = sim.scene().add_joint(joint);
  ToolHandle tool = sim.scene().add_tool({.shape = Sphere{0.006}, .pose = {.position = corner}});
  tool.grasp(0.002);
  ASSERT_TRUE(sim.advance(0.005).ok());
  ASSERT_GT(sim.solver().held(tool), 0);
  const Snapshot before = sim.snapshot();
  sim.remove_cells(cells_within(model, corner, 0.02));
  ASSERT_EQ(model.mass[at], 0.0);
  ASSERT_TRUE(sim.advance(0.005).ok());
  EXPECT_EQ(sim.solver().held(tool), 0);
  EXPECT_EQ(sim.force_on(tool).force, Vec3::Zero());
  EXPECT_TRUE(sim.report_of(held).springs[0].broken);
  EXPECT_FALSE(sim.report_of(held).springs[1].broken);
  EXPECT_EQ(sim.report_of(held).broken, 1);
  sim.restore(before);
  ASSERT_TRUE(sim.advance(0.005).ok());
  EXPECT_FALSE(sim.report_of(held).springs[0].broken);
}

TEST_P(RemovedCellsOn, OpenAVolume) {
  Simulation sim(make_block({0.03, 0.03, 0.03}, 3, 3, 3), options_for(GetParam()));
  sim.scene().fix("z0").gravity({0, 0, -30}).constrain_volume();
  EXPECT_FALSE(sim.scene().any_volume_open());
  ASSERT_TRUE(sim.advance(0.001).ok());
  sim.remove_cells(std::vector<Index>{26});
  EXPECT_TRUE(sim.scene().is_open(0));
  const StepReport report = sim.advance(0.1);
  EXPECT_TRUE(report.ok()) << report.message();
}

/// A chamber within corners of the block, none of whose triangles is at a cell, as lids of a tube are not.
TEST(RemovedCells, LeaveLidsClosed) {
  Simulation sim(make_block({0.03, 0.03, 0.03}, 3, 3, 3), options_for("reference"));
  const auto at = [&](const Vec3& corner) {
    const VecList& rest = sim.model().rest;
    return static_cast<Index>(std::ranges::find(rest, corner) - rest.begin());
  };
  const Index o = at({0, 0, 0}), x = at({0.03, 0, 0}), y = at({0, 0.03, 0}), z = at({0, 0, 0.03});
  VolumeConstraint chamber{.triangles = {{o, x, y}, {o, z, x}, {x, z, y}, {y, z, o}}, .volume = 4.5e-6, .name = "c"};
  EXPECT_TRUE(refuses([&] { sim.scene().constrain_volume(chamber); }, "at rest they are wound inward"));
  for (auto& triangle : chamber.triangles) std::swap(triangle[0], triangle[1]);
  sim.scene().constrain_volume(chamber);
  sim.remove_cells(std::vector<Index>{26});
  EXPECT_FALSE(sim.scene().is_open(0));
}

TEST(RemovedCells, LeaveLoadsOnWhatIsThere) {
  Simulation sim(make_block({0.03, 0.03, 0.03}, 3, 3, 3), options_for("reference"));
  const auto top = sim.model().group("z1");
  sim.scene().fix("z0").add({.type = LoadType::pressure, .particles = top, .events = {{0.0, 10.0}}});
  const auto load = [&] {
    LoadFrame frame;
    sim.scene().prepare(frame);
    sim.scene().evaluate(0.0, frame);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& f : frame.force) sum += f;
    return sum;
  };
  const double whole = load().norm();
  EXPECT_NEAR(whole, 10.0 * 9e-4, 1e-12);
  sim.remove_cells(std::vector<Index>{26});
  EXPECT_NEAR(load().norm(), whole * 8.0 / 9.0, 1e-12);
  for (Index row = 18; row < 26; ++row) sim.remove_cells(std::vector<Index>{row});
  EXPECT_EQ(load().norm(), 0.0);
  EXPECT_TRUE(sim.advance(0.01).ok());
}

/// What is imposed moves what is there; what comes back goes along again.
TEST_P(RemovedCellsOn, StayAtTheirPlacesWhateverIsImposed) {
  for (const LoadType type : {LoadType::translation, LoadType::rotation}) {
    Simulation sim(make_block({0.03, 0.03, 0.03}, 3, 3, 3), options_for(GetParam()));
    const Model& model = sim.model();
    const Load load{
        .type = type, .particles = model.group("x1"), .events = {{0.0, 0.0}, {0.01, 1e-3}}, .direction = {1, 0, 0}};
    sim.scene().fix("x0").add(load);
    sim.step(2, 1e-4);
    const Snapshot whole = sim.snapshot();
    sim.remove_cells(model.cells_in([](const Vec3& x) { return x.x() > 0.02 && x.y() > 0.02; }));
    ASSERT_EQ(std::ranges::count(model.mass, 0.0), 4);
    for (const bool is_back : {false, true}) {
      if (is_back) sim.restore(whole);
      sim.step(10, 1e-4);
      const State state = sim.solver().read();
      for (const Index i : load.particles) {
        const double moved = (state.position[i] - model.rest[i]).norm();
        if (model.mass[i] > 0.0) {
          EXPECT_GT(moved, 1e-7);
        } else {
          EXPECT_EQ(moved, 0.0);
          EXPECT_EQ(state.velocity[i].norm(), 0.0);
        }
      }
    }
  }
}

PHYMUL_ON_EVERY_BACKEND(RemovedCellsOn);

}  // namespace
}  // namespace phymul
