// SPDX-License-Identifier: MIT
//
// Velocities of Simulation::state() where tools, contacts and volume constraints act in the step.
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr Material tissue_of_organs{.young = 10e3, .poisson = 0.3, .density = 1000};

class VelocityOfStateOn : public WithTools {
 protected:
  static Simulation pressed(ToolContact contact) {
    Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4),
                   {.material = tissue_of_organs, .backend = GetParam(), .damping = {.rate = 100.0}, .step = 0.5});
    sim.scene().fix("z0").add_tool(
        "plate", {.shape = Box{{0.03, 0.03, 0.01}}, .pose = {.position = {0.02, 0.02, 0.05}}, .contact = contact});
    return sim;
  }
  static void move_down(Simulation& sim, double by) {
    const Vec3 place = sim.pose_of(sim.scene().tool("plate")).position;
    sim.scene().tool("plate").move_to({.position = place - Vec3(0, 0, by)});
    ASSERT_TRUE(sim.advance(1e-3).ok());
  }
};
PHYMUL_ON_EVERY_BACKEND(VelocityOfStateOn);

TEST_P(VelocityOfStateOn, IsThatOfAToolWhichPresses) {
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    Simulation sim = pressed(contact);
    for (int k = 0; k < 40; ++k) move_down(sim, 1e-4);
    const VecList moving = sim.state().velocity;
    for (const Index i : sim.model().group("z1")) EXPECT_NEAR(moving[i].z(), -0.1, 2e-3);
    for (int k = 0; k < 400; ++k) move_down(sim, 0.0);
    EXPECT_GT(sim.force_on(sim.scene().tool("plate")).force.norm(), 0.5);
    EXPECT_LT(largest_norm(sim.state().velocity), 1e-4);
  }
}

TEST_P(VelocityOfStateOn, IsZeroOfWhatContactsAndConstraintsHold) {
  for (const bool touches : {true, false}) {
    const Model low = make_block({0.03, 0.03, 0.01}, 5, 5, 2), cube = make_block({0.01, 0.01, 0.01}, 2, 2, 2);
    const Model high = moved(cube, {0.0072, 0.0081, 0.0111});
    Simulation sim(merged({{"low", &low}, {"high", &high}}),
                   {.material = tissue_of_organs, .backend = GetParam(), .damping = {.rate = 100.0}, .step = 0.5});
    sim.scene().fix("low/z0").gravity({0, 0, -9.81});
    if (touches) sim.scene().contacts({});
    if (!touches) sim.scene().fix("high/z0").constrain_volume("high");
    ASSERT_TRUE(sim.advance(0.8).ok());
    ASSERT_LT(largest_norm(sim.solver().read().velocity), 1e-4);
    EXPECT_LT(largest_norm(sim.state().velocity), 1e-4);
    const VecList before = sim.solver().read().velocity;
    sim.set_state(sim.state());
    EXPECT_LT(largest_distance(sim.solver().read().velocity, before), 1e-4);
  }
}

}  // namespace
}  // namespace phymul::test
