// SPDX-License-Identifier: MIT
//
// A needle on the skin: dry friction alone holds what it presses until it punctures, and what another tool holds stays
// where that one has it.
#include <algorithm>

#include "support/needle_insertion.h"

namespace phymul::test {
namespace {

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
