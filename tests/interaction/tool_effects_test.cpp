// SPDX-License-Identifier: MIT
//
// Tools: what is imposed takes its part of a push by itself, what leaves by itself is not held back, and where a tool
// goes between two poses.
#include <algorithm>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

using ToolEffects = WithTools;
PHYMUL_ON_EVERY_BACKEND(ToolEffects);

/// A ball whose centre is out of the plane pushes a flat body askew, and feels it only in the plane.
TEST_P(ToolEffects, NothingOutOfAFlatBodysPlane) {
  const Model model = make_strip(0.04, 0.02, 8, 4);
  Scene scene(model);
  scene.fix("y0").add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.02, 0.0264, 0.004}}});
  const auto solver = make(model, scene);
  double most = 0.0;
  for (int k = 1; k <= 20; ++k) {
    scene.tool("ball").move_to({.position = {0.02, 0.0264 - 1e-4 * k, 0.004}});
    ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
    const Vec3& force = solver->tool_force("ball").force;
    EXPECT_EQ(force.z(), 0.0) << k;
    most = std::max(most, force.norm());
  }
  EXPECT_GT(most, 1e-6);
}

/// Likewise where loads impose one coordinate of what it pushes.
TEST_P(ToolEffects, NothingAlongAnImposedAxis) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  for (int axis = 0; axis < 2; ++axis) {
    Scene scene = Scene(model).fix("z0");
    Load held{
        .type = LoadType::translation, .particles = model.group("z1"), .axes = {Axis::free, Axis::free, Axis::free}};
    held.axes[static_cast<std::size_t>(axis)] = Axis::held;
    scene.add(held);
    // Between lattice points, so that it pushes aside whatever it meets.
    const Vec3 above(0.0085, 0.0085, 0.028);
    scene.add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = above}, .friction = 0.4});
    const auto solver = make(model, scene);
    double most = 0.0;
    for (int k = 1; k <= 10; ++k) {
      scene.tool("ball").move_to({.position = above - Vec3(0, 0, 2e-4 * k)});
      ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
      const Vec3& force = solver->tool_force("ball").force;
      EXPECT_EQ(force[axis], 0.0) << axis << ", " << k;
      most = std::max(most, std::abs(force[1 - axis]));
    }
    EXPECT_GT(most, 1e-3);
  }
}

/// A floor put over what is on its way out of it: that comes out, and nothing draws it back.
TEST_P(ToolEffects, NothingOfWhatLeavesByItself) {
  const Model model = make_block({0.01, 0.01, 0.01}, 1, 1, 1);
  Scene scene(model);
  constexpr double deep = 1e-4;  // m
  scene.add_tool("floor", {.shape = HalfSpace{}, .pose = {.position = {0, 0, deep}}});
  const auto solver = make(model, scene, {.on_unstable = UnstableStep::allow});
  const double dt = 0x1p-10;
  State state = rest_state(model);
  for (Vec3& v : state.velocity) v = {0, 0, 0.5 * deep / dt};
  solver->reset(state);
  ASSERT_TRUE(solver->step(1, dt).ok());
  const State end = solver->read();
  EXPECT_LE(solver->tool_force("floor").force.norm() * dt, 1e4 * roundoff() * 0.5 * deep / dt);  // N s, of 1 kg each
  for (const Vec3& v : end.velocity) EXPECT_NEAR(v.z(), 0.5 * deep / dt, 1e4 * roundoff() * deep / dt);
  for (const Index i : model.group("z0")) EXPECT_NEAR(end.position[i].z(), deep, 1e3 * roundoff() * 0.01);
}

/// What loads hold with all its coordinates takes no push, and the tool neither feels nor counts it.
TEST_P(ToolEffects, WhatIsImposedWholeIsNotCounted) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  scene.fix("z0").fix("z1").add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.027}}});
  const auto solver = make(model, scene);
  ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
  EXPECT_EQ(solver->tool_force("ball").particles, 0);
  EXPECT_EQ(solver->tool_force("ball").force, Vec3::Zero());
}

/// Head first: with the cap that is further along its axis.
TEST_P(ToolEffects, ARodTouchesWithItsFarCap) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  const double radius = 0.002, length = 0.03, deep = 1e-4;  // m
  const ToolPose down{.position = {0.01, 0.01, 0.02 + length + radius - deep}, .orientation = {0, 1, 0, 0}};
  scene.fix("z0").add_tool("rod", {.shape = Capsule{radius, length}, .pose = down});
  const auto solver = make(model, scene);
  ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
  EXPECT_EQ(solver->tool_force("rod").particles, 1);
  EXPECT_GT(solver->tool_force("rod").force.z(), 0.0);
}

/// A rod that turns by 60 degrees in one step reaches further out on its way than where it begins and ends.
TEST(ToolSwing, MeetsWhatIsBeyondTheChord) {
  const double length = 0.02;
  const Model model = moved(make_block(Vec3::Constant(5e-4), 1, 1, 1), {0, -2.5e-4, 0.93 * length});
  const auto turned = [](double angle) { return Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitX())); };
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(model);
    scene.add_tool("rod", {.shape = Capsule{5e-4, length}, .pose = {.orientation = turned(M_PI / 6)}});
    const auto solver = make_solver(backend, model, scene);
    scene.tool("rod").move_to({.orientation = turned(-M_PI / 6)});
    ASSERT_TRUE(solver->step(1, 0.3 * solver->stable_step()).ok());
    EXPECT_GT(solver->tool_force("rod").particles, 0) << backend;
  }
}

}  // namespace
}  // namespace phymul::test
