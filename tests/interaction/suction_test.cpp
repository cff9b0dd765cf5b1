// SPDX-License-Identifier: MIT
//
// Tools that draw tissue (Tool::suction).
#include <algorithm>
#include <functional>

#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double cube_side = 0.02;

using Suction = WithTools;
PHYMUL_ON_EVERY_BACKEND(Suction);

/// A step of a free body at rest: each particle gets its share, and the tool feels them all.
TEST_P(Suction, IsSharedByMassAndDistance) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 4, 4, 4);
  const Vec3 mouth(0.009, 0.008, cube_side + 0.004);
  constexpr double radius = 0.002, reach = 0.008, suction = 0.3, dt = 1e-4;
  Scene scene(model);
  scene.add_tool("tube",
                 {.shape = Sphere{radius}, .pose = {.position = mouth}, .suction = suction, .suction_reach = reach});
  const auto solver = make(model, scene);
  const double felt = balanced_step(*solver, {"tube"}, dt);
  double mass = 0.0;  // kg, within reach
  const auto gap = [&](Index i) { return (model.rest[i] - mouth).norm() - radius; };
  for (Index i = 0; i < model.particle_count(); ++i) mass += gap(i) < reach ? model.mass[i] : 0.0;
  Vec3 total = Vec3::Zero();
  int drawn = 0;
  const State after = solver->read();
  for (Index i = 0; i < model.particle_count(); ++i) {
    const double weight = std::max(0.0, 1.0 - gap(i) / reach);
    const Vec3 force = suction * model.mass[i] / mass * weight * (mouth - model.rest[i]).normalized();
    EXPECT_LE((after.position[i] - model.rest[i] - dt * dt / model.mass[i] * force).norm(), 1e-10) << i;
    total += force;
    drawn += weight > 0.0;
  }
  EXPECT_GT(drawn, 10);
  EXPECT_NEAR(felt, total.norm(), 1e-6 * suction);
  EXPECT_LT(felt, suction);
  EXPECT_EQ(solver->tool_force("tube").particles, 0) << "pressed or held";
}

/// Not even in the step in which it alone makes it touch.
TEST_P(Suction, DrawsNothingIntoTheTool) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 4, 4, 4);
  Scene scene = Scene(model).fix("z0");
  scene.add_tool("cup", {.shape = Box{{0.02, 0.02, 0.002}},
                         .pose = {.position = {0.01, 0.01, cube_side + 0.0023}},
                         .suction = 0.1,
                         .suction_reach = 0.002});
  const auto solver = make(model, scene, {.damping = {.rate = 20.0}});
  const double dt = 0.3 * solver->stable_step();
  for (int step = 0; step < 60; ++step) {
    ASSERT_TRUE(solver->step(1, dt).ok());
    const State state = solver->read();
    for (const Index i : model.group("z1")) ASSERT_LE(state.position[i].z(), cube_side + 0.0003 + 1e-8) << step;
  }
  EXPECT_EQ(solver->tool_force("cup").particles, 25);
}

/// It draws the tissue to the tool, holds it there while the tool goes away, and lets go above its force.
TEST_P(Suction, LiftsTissueUpToItsForce) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 6, 6, 6);
  const auto lifted = [&](double suction, double rise) {
    Scene scene = Scene(model).fix("z0");
    scene.add_tool("tube", {.shape = Sphere{0.004},
                            .pose = {.position = {0.01, 0.01, cube_side + 0.0045}},
                            .friction = 0.3,
                            .suction = suction,
                            .suction_reach = 0.003});
    const auto solver = make(model, scene, {.damping = 20.0});
    const double dt = 0.4 * solver->stable_step();
    EXPECT_TRUE(solver->step(200, dt).ok());
    scene.tool("tube").move_to({.position = {0.01, 0.01, cube_side + 0.0045 + rise}});
    EXPECT_TRUE(solver->step(600, dt).ok());
    EXPECT_TRUE(solver->step(200, dt).ok());
    const State state = solver->read();
    double top = 0.0;
    for (const Vec3& x : state.position) top = std::max(top, x.z());
    return std::pair(top - cube_side, solver->tool_force("tube").mean_force.z());
  };
  const auto [height, force] = lifted(2.0, 0.002);
  EXPECT_GT(height, 0.0022) << "in contact: the tool was 0.5 mm above";
  EXPECT_LT(force, -0.02);
  EXPECT_GT(force, -2.0);
  const auto [left, none] = lifted(0.02, 0.006);
  EXPECT_LT(left, 1e-4) << "torn off";
  EXPECT_EQ(none, 0.0);
}

TEST(SuctionOptions, AreThoseOfTheSnapshot) {
  const Tool tube{.shape = Sphere{1e-3}, .pose = {.position = {0, 0, 0.1}}, .suction = 0.05, .suction_reach = 2e-3};
  for (const auto& change : {std::function([](Tool& tool) { tool.suction = 0.0; }),
                             std::function([](Tool& tool) { tool.suction_reach = 3e-3; })}) {
    Simulation sim(soft_block({cube_side, cube_side, cube_side}, 2, 2, 2), {.backend = "reference"});
    sim.scene().add_tool("tube", tube);
    const Snapshot before = sim.snapshot();
    Tool other = tube;
    change(other);
    sim.scene().remove_tool("tube").add_tool("tube", other);
    EXPECT_TRUE(says(message_of([&] { sim.unrecorded_solver().restore(before); }), "is tool \"tube\""));
    sim.restore(before);
    EXPECT_EQ(sim.scene().tools()[0].tool.suction, 0.05);
    EXPECT_EQ(sim.scene().tools()[0].tool.suction_reach, 2e-3);
  }
}

TEST(SuctionOptions, WhatMakesNoSenseIsRefused) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 2, 2, 2);
  Scene scene(model);
  const auto message = [&](const Tool& tool) { return message_of([&] { scene.add_tool("tube", tool); }); };
  EXPECT_TRUE(says(message({.shape = Sphere{1e-3}, .suction = -1}), "suction (N), 0 or more; got -1"));
  EXPECT_TRUE(says(message({.shape = Sphere{1e-3}, .suction = 1}), "a suction reach above 0 m, got 0"));
  EXPECT_TRUE(says(message({.shape = Needle{}, .suction = 1, .suction_reach = 1e-3}), "a suction of 0 N for a needle"));
}

}  // namespace
}  // namespace phymul::test
