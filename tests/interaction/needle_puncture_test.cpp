// SPDX-License-Identifier: MIT
//
// Needles with their defaults: where the tissue gives way does not depend on the mesh, and no cell turns inside out.
#include <algorithm>

#include "support/needle_insertion.h"
#include "support/sanitized.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double punctured_side = 0.072;        // m, of a block
constexpr double needle_spread = 34 * 0.64e-3;  // m, of the default needle
constexpr double punctured_part = 5e-5;         // m, of the way in a call

/// A needle over the middle of a block whose bottom is held, off the lattice's lines.
struct Default {
  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
  double depth = 0.0;  // m, of the tip below the block's top
  double most = 0.0;   // N on the hub before the puncture
  int gave_way = 0;    // StepReport::tissue_gave_way
  double speed;        // m/s

  Default(double spacing, double young, const Needle& needle = {}, double poisson = 0.45, double at_speed = 0.03)
      : model(block(spacing, {.young = young, .poisson = poisson, .density = 1000.0})), scene(model), speed(at_speed) {
    scene.fix("z0").add_tool("needle", {.shape = needle, .pose = pose(), .friction = 0.3});
    solver = make_solver("cpu", model, scene, {}, damped(40.0));
  }
  static Model block(double spacing, const Material& material) {
    const int cells = static_cast<int>(std::lround(punctured_side / spacing));
    return with_material(make_block({punctured_side, punctured_side, punctured_side}, cells, cells, cells), material);
  }
  ToolPose pose() const {
    return {.position = {0.5 * punctured_side + 0.3e-3, 0.5 * punctured_side - 0.2e-3, punctured_side - depth}};
  }
  bool punctured() const { return solver->read().tools.at(0).needle.punctured; }

  /// Deeper until it has punctured, or as deep as `deepest`. False where a cell is beyond the law.
  bool go(double deepest, bool to_puncture) {
    const double dt = 0.4 * solver->stable_step();
    while (depth < deepest && !(to_puncture && punctured())) {
      depth += punctured_part;
      scene.tool("needle").move_to(pose());
      const StepReport report =
          solver->step(std::max(1, static_cast<int>(std::lround(punctured_part / speed / dt))), dt);
      EXPECT_TRUE(is_ok(report));
      gave_way += report.tissue_gave_way;
      if (report.beyond_law > 0 || report.inverted > 0) return false;
      if (to_puncture) most = std::max(most, solver->tool_force("needle").force.z());
    }
    return true;
  }
};

TEST(NeedlePuncture, IsThatOfFinerMeshes) {
  for (const double young : {2e3, 5e3, 20e3}) {
    std::vector<double> force, depth;
    for (const double spacing : {9e-3, 6e-3, 4e-3, 3e-3}) {
      if (sanitized && spacing < 6e-3) continue;
      Default needle(spacing, young);
      ASSERT_TRUE(needle.go(0.03, true)) << young << ", " << spacing;
      ASSERT_TRUE(needle.punctured()) << young << ", " << spacing;
      // Which of the two came first.
      EXPECT_EQ(needle.gave_way, young < 10e3 ? 1 : 0) << young;
      force.push_back(needle.most);
      depth.push_back(needle.depth);
    }
    const auto [least_force, most_force] = std::ranges::minmax(force);
    const auto [least_depth, most_depth] = std::ranges::minmax(depth);
    RecordProperty("force_" + std::to_string(static_cast<int>(young)), std::to_string(most_force));
    RecordProperty("depth_" + std::to_string(static_cast<int>(young)), std::to_string(most_depth));
    EXPECT_LE(most_force, 1.15 * least_force) << young;
    EXPECT_LE(most_depth, 1.15 * least_depth) << young << ": " << least_depth << " to " << most_depth;
    EXPECT_NEAR(most_force, std::min(2.0, young * needle_spread * needle_spread / (1.25 + 0.6 + 0.085)),
                0.05 * most_force)
        << young;
  }
}

/// Beside an edge the skin bulges and slides along under a tip without friction, by 2 mm. The needle goes in where the
/// tip is: drawing the place back to it where both met first would take 12 N.
TEST(NeedlePuncture, IsWhereTheTipIs) {
  const Model model = with_material(make_tetrahedral_block({0.06, 0.04, 0.02}, 9, 6, 3, 0.1, 1), {1e4, 0.45, 1000.0});
  Scene scene(model);
  ToolPose pose{.position = {0.055, 0.02, 0.021}};
  const ToolHandle needle =
      scene.fix("z0").add_tool("needle", {.shape = Needle{.puncture = 0.5, .cutting = 0.2}, .pose = pose});
  const auto solver = make_solver("cpu", model, scene, {}, damped(40.0));
  const double dt = 0.4 * solver->stable_step();
  const int steps = static_cast<int>(1e-3 / dt);
  double aside = 0.0, slid = 0.0;
  for (int tick = 0; tick < 120; ++tick) {
    pose.position.z() -= 1e-4;
    needle.move_to(pose);
    ASSERT_TRUE(is_ok(solver->step(steps, dt)));
    const State now = solver->read();
    const NeedleState& state = now.tools.front().needle;
    aside = std::max(aside, solver->tool_force("needle").mean_force.head<2>().norm());
    if (state.hole.empty() || state.punctured) continue;
    Vec3 skin = Vec3::Zero();
    for (std::size_t k = 0; k < state.hole.front().particles.size(); ++k) {
      skin += state.hole.front().weights[k] * now.position[state.hole.front().particles[k]];
    }
    slid = std::max(slid, (skin - pose.position).head<2>().norm());
  }
  EXPECT_TRUE(solver->read().tools.front().needle.punctured);
  EXPECT_GT(slid, 1.5e-3);
  EXPECT_LT(aside, 0.5);
}

TEST(NeedlePuncture, TurnsNoCellInsideOut) {
  for (const double poisson : {0.3, 0.45, 0.49}) {
    for (const double given : {0.0, 0.008}) {  // m
      for (const double spacing : {9e-3, 6e-3, 4e-3}) {
        if (sanitized && (poisson != 0.45 || spacing < 6e-3)) continue;
        SCOPED_TRACE(testing::Message() << poisson << ", " << given << ", " << spacing);
        Default needle(spacing, 5e3, {.spread = given}, poisson, 0.1);
        EXPECT_TRUE(needle.go(0.04, false));
        EXPECT_TRUE(needle.punctured());
        EXPECT_EQ(first_folded_cell(needle.model, needle.solver->read().position), -1);
      }
    }
  }
}

/// A capsule of 1 nm holds nothing. Where a spread over a quarter of the body asks for more force than the tissue
/// bears, it gives way as without one.
TEST(NeedlePuncture, BearsWhatTheTissueBelowACapsuleBears) {
  const Needle wide{.spread = 12.5e-3};
  Default bare(6e-3, 5e3, wide), capsule(6e-3, 5e3, wide);
  add_capsule(capsule.model, {.young = 1e6, .poisson = 0.45, .density = 1000.0, .thickness = 1e-9});
  capsule.solver = make_solver("cpu", capsule.model, capsule.scene, {}, damped(40.0));
  ASSERT_TRUE(bare.go(0.02, true) && capsule.go(0.02, true));
  EXPECT_GT(bare.gave_way, 0);
  EXPECT_NEAR(capsule.most, bare.most, 0.02 * bare.most);
}

/// The limit follows the tissue's present stiffness.
TEST(NeedlePuncture, IsLaterInTissueThatWasMadeStiffer) {
  Default soft(9e-3, 4e3), stiff(9e-3, 4e3);
  stiff.scene.scale_stiffness(2.0);
  ASSERT_TRUE(soft.go(0.03, true) && stiff.go(0.03, true));
  EXPECT_NEAR(stiff.most / soft.most, 2.0, 0.1);
}

// A needle on the skin: dry friction alone holds what it presses until it punctures, and what another tool holds
// stays where that one has it.

using NeedleOnSkin = WithTools;
PHYMUL_ON_EVERY_BACKEND(NeedleOnSkin);

TEST_P(NeedleOnSkin, StaysInItsConeUntilItPunctures) {
  constexpr double friction = 0.5;              // Insertion's
  for (const double stiffness : {0.0, 2e-2}) {  // N m^2; 0: a stiff shaft
    SCOPED_TRACE(stiffness);
    Needle blunt = bending(stiffness);
    blunt.puncture = 50.0;
    Insertion needle(GetParam(), 4, 0.5, blunt);
    needle.go(0.002, 0.1, 5);
    double most = 0.0;
    for (int k = 0; k < 20; ++k) {
      needle.pose.position.x() += 0.4e-3;
      needle.scene.tool("needle").move_to(needle.pose);
      ASSERT_TRUE(needle.solver->step(4, needle.dt).ok());
      const Vec3 force = needle.solver->tool_force("needle").force;
      ASSERT_GT(force.z(), 0.02);
      const double across = force.head<2>().norm() / force.z();
      EXPECT_LE(across, friction * (1.0 + 1e3 * roundoff())) << k;
      most = std::max(most, across);
    }
    EXPECT_GT(most, 0.99 * friction);  // it was dragged hard enough to slide
    EXPECT_FALSE(needle.solver->read().tools.at(0).needle.punctured);
  }
}

TEST_P(NeedleOnSkin, PushesNothingThatAnotherToolHolds) {
  Insertion needle(GetParam(), 5, 0.5);
  const Vec3 at(0.25 * block_side, 0.5 * block_side, block_side);  // on one side of the needle
  needle.scene.add_tool("clamp", {.shape = Box{{0.007, 0.021, 0.009}}, .pose = {.position = at}});
  needle.scene.tool("clamp").grasp(0.0);
  needle.go(0.004, 0.2, 4);
  const State state = needle.solver->read();
  const ToolState& clamp = state.tools.at(1);
  ASSERT_EQ(clamp.name, "clamp");
  ASSERT_GE(clamp.held.size(), 8u);
  EXPECT_GT(needle.solver->tool_force("needle").force.z(), 0.01);
  for (std::size_t k = 0; k < clamp.held.size(); ++k) {
    const Vec3 place = at + clamp.held_at[k];
    EXPECT_LE((state.position[clamp.held[k]] - place).norm(), 100.0 * roundoff() * block_side) << clamp.held[k];
  }
}

/// What turns slides: kinetic friction all around the shaft, whether it goes along or not.
TEST(NeedleShaft, TurningOnTheSpotIsRubbedByKineticFriction) {
  for (const char* backend : {"reference", "cpu"}) {
    Needle sticky = thin_needle();
    sticky.static_friction = 30.0;
    Insertion needle(backend, 5, 0.5, sticky);
    needle.go(0.02, 0.2, 10);
    needle.pose.spin = {0, 0, 300};
    needle.scene.tool("needle").teleport(needle.pose);
    ASSERT_TRUE(needle.solver->step(static_cast<int>(0.1 / needle.dt), needle.dt).ok());
    const State state = needle.solver->read();
    const double top = place_of(state.tools.at(0).needle.hole.at(0), state).z();
    const double most = sticky.kinetic_friction * (top - needle.pose.position.z()) * sticky.radius;  // N m
    EXPECT_NEAR(-needle.solver->tool_force("needle").torque.z(), most, 0.05 * most) << backend;
  }
}

/// A shaft that begins within the body and comes out of it has not come in anywhere.
TEST(NeedleShaft, ThatComesOutOfTheBodyMakesNoHole) {
  Needle stub = thin_needle();
  stub.length = 0.02;
  Insertion needle("cpu", 4, 0.5, stub);
  needle.pose.position.z() = -0.005;
  needle.scene.tool("needle").teleport(needle.pose);
  ASSERT_TRUE(needle.solver->step(3, needle.dt).ok());
  EXPECT_TRUE(needle.solver->read().tools.at(0).needle.hole.empty());
}

}  // namespace

}  // namespace phymul::test
