// SPDX-License-Identifier: MIT
#include <cmath>

#include "message_of.h"
#include "tool_backends.h"

namespace phymul::test {
namespace {

TEST(VirtualCoupling, FollowsTheHandWhereNothingIsInTheWay) {
  VirtualCoupling coupling({}, {});
  const ToolPose hand{.position = {0.1, -0.05, 0.02},
                      .orientation = Quaternion(Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()))};
  for (int k = 0; k < 2000; ++k) coupling.follow(hand, Vec3::Zero(), Vec3::Zero(), 1e-3);
  EXPECT_LE((coupling.tool().position - hand.position).norm(), 1e-9);
  EXPECT_LE(coupling.tool().orientation.angularDistance(hand.orientation), 1e-7);
  EXPECT_LE(coupling.force().norm(), 1e-6);
}

TEST(VirtualCoupling, PassesAForceOnToTheHandUpToTheLimit) {
  const Vec3 push(0, 0, 2.0), twist(0.01, 0, 0);
  VirtualCoupling coupling({}, {});
  for (int k = 0; k < 3000; ++k) coupling.follow({}, push, twist, 1e-3);
  EXPECT_NEAR((coupling.force() - push).norm(), 0.0, 1e-6);
  EXPECT_NEAR((coupling.torque() - twist).norm(), 0.0, 1e-6);
  EXPECT_NEAR(coupling.tool().position.z(), 2.0 / 500.0, 1e-8);
  for (int k = 0; k < 3000; ++k) coupling.follow({}, 10.0 * push, twist, 1e-3);
  EXPECT_NEAR(coupling.force().norm(), 5.0, 1e-9);
}

TEST(VirtualCoupling, IsStableHoweverStiff) {
  CouplingOptions stiff;
  stiff.stiffness = 1e9;
  stiff.turning_stiffness = 1e7;
  VirtualCoupling coupling(stiff, {});
  const ToolPose hand{.position = {0.1, 0, 0}};
  for (int k = 0; k < 100; ++k) {
    coupling.follow(hand, Vec3::Zero(), Vec3::Zero(), 1e-3);
    ASSERT_LE(coupling.tool().position.norm(), 0.1 * (1 + 1e-4));
  }
  EXPECT_NEAR(coupling.tool().position.x(), 0.1, 1e-6);
}

TEST(VirtualCoupling, RefusesWhatMakesNoSense) {
  EXPECT_NE(message_of([] { VirtualCoupling({.mass = 0.0}, {}); }).find("mass (kg) above 0; got 0"), std::string::npos);
  EXPECT_NE(message_of([] { VirtualCoupling({.stiffness = -1.0}, {}); }).find("stiffness (N/m), 0 or more; got -1"),
            std::string::npos);
}

/// A device that loses its bearings for a tick must not leave the tool without a place for good.
TEST(VirtualCoupling, LeavesOutATickThatIsNotFinite) {
  const ToolPose hand{.position = {0.01, 0, 0}, .velocity = {0.1, 0, 0}};
  VirtualCoupling coupling({}, {});
  for (int k = 0; k < 10; ++k) coupling.follow(hand, {0, 0, 1}, Vec3::Zero(), 1e-3);
  const ToolPose before = coupling.tool();
  const Vec3 force = coupling.force(), torque = coupling.torque();
  const double no_number = std::nan("");
  const auto follows = [&](const ToolPose& device, const Vec3& push, const Vec3& twist, double dt) {
    const ToolPose after = coupling.follow(device, push, twist, dt);
    EXPECT_EQ(after, before);
    EXPECT_EQ(coupling.force(), force);
    EXPECT_EQ(coupling.torque(), torque);
  };
  const Vec3 bad(0, no_number, 0), none = Vec3::Zero();
  follows({.position = bad}, none, none, 1e-3);
  follows({.orientation = {no_number, 0, 0, 0}}, none, none, 1e-3);
  follows({.velocity = {0, INFINITY, 0}}, none, none, 1e-3);
  follows({.spin = bad}, none, none, 1e-3);
  follows(hand, bad, none, 1e-3);
  follows(hand, none, bad, 1e-3);
  for (const double dt : {no_number, double{INFINITY}, -1e-3}) follows(hand, none, none, dt);
  follows({.position = {1e300, 0, 0}}, none, none, 1e-3);  // finite, but not its square
  for (int k = 0; k < 3000; ++k) coupling.follow(hand, none, none, 1e-3);
  EXPECT_TRUE(coupling.tool().position.allFinite());
  EXPECT_NEAR(coupling.tool().position.x(), hand.position.x() + 5.0 * 0.1 / 500.0, 1e-6);  // spring against damper
}

TEST(VirtualCoupling, StartsAnewWhereTheDeviceIs) {
  VirtualCoupling coupling({}, {});
  for (int k = 0; k < 10; ++k) coupling.follow({.position = {0.1, 0, 0}}, Vec3::Zero(), Vec3::Zero(), 1e-3);
  ASSERT_GT(coupling.force().norm(), 1.0);
  const ToolPose place{.position = {0, 0.2, 0}, .orientation = Quaternion(0, 2, 0, 0)};
  coupling.reset(place);
  EXPECT_EQ(coupling.tool().position, place.position);
  EXPECT_EQ(coupling.tool().orientation, Quaternion(0, 1, 0, 0));
  EXPECT_EQ(coupling.force(), Vec3(Vec3::Zero()));
  EXPECT_EQ(coupling.torque(), Vec3(Vec3::Zero()));
  coupling.follow(place, Vec3::Zero(), Vec3::Zero(), 1e-3);
  EXPECT_LE((coupling.tool().position - place.position).norm(), 1e-15);
  const ToolPose nowhere{.position = {std::nan(""), 0, 0}};
  const ToolPose unturned{.orientation = Quaternion(0, 0, 0, 0)};
  for (const ToolPose& pose : {nowhere, unturned}) {
    EXPECT_NE(message_of([&] { coupling.reset(pose); }).find("expected a pose of finite numbers"), std::string::npos);
    EXPECT_NE(message_of([&] { VirtualCoupling({}, pose); }).find("expected a pose of finite"), std::string::npos);
  }
  EXPECT_EQ(coupling.tool().position, place.position);
}

/// The loop of a haptic program at 1 kHz: a hand goes 4 mm into a block and rests there.
TEST(VirtualCoupling, HandPressingABlockFeelsASteadyForce) {
  const Model model = soft_block({0.03, 0.03, 0.03}, 4, 4, 4);
  Scene scene(model);
  ToolPose hand{.position = {0.015, 0.015, 0.041}};
  scene.fix("z0").add_tool("probe", {.shape = Sphere{0.01}, .pose = hand});
  SolverOptions options;
  options.damping.rate = 20.0;
  const auto solver = make_solver("cpu", model, scene, {}, options);
  const int steps = static_cast<int>(std::ceil(1e-3 / (0.5 * solver->stable_step())));
  VirtualCoupling coupling({}, hand);
  const ToolHandle probe = scene.tool("probe");
  double least = INFINITY, most = 0.0, jump = 0.0, before = 0.0;
  for (int k = 0; k < 1500; ++k) {
    hand.velocity = k < 200 ? Vec3(0, 0, -0.025) : Vec3(Vec3::Zero());
    hand.position += 1e-3 * hand.velocity;
    const ToolForce& on_tool = solver->tool_force(probe);
    probe.pose(coupling.follow(hand, on_tool.mean_force, on_tool.mean_torque, 1e-3));
    ASSERT_TRUE(solver->step(steps, 1e-3 / steps).ok());
    const double force = coupling.force().z();
    jump = std::max(jump, std::abs(force - before));
    before = force;
    if (k >= 1300) least = std::min(least, force), most = std::max(most, force);
  }
  EXPECT_GT(least, 0.1);
  EXPECT_LE(most - least, 0.02 * most);
  EXPECT_LE(jump, 0.25);  // N from one tick to the next: nothing a hand would call a knock
}

}  // namespace
}  // namespace phymul::test
