// SPDX-License-Identifier: MIT
#include <cmath>

#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

TEST(VirtualCoupling, FollowsTheHandWhereNothingIsInTheWay) {
  VirtualCoupling coupling({}, {});
  const ToolPose hand{.position = {0.1, -0.05, 0.02},
                      .orientation = Quaternion(Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()))};
  for (int k = 0; k < 2000; ++k) coupling.follow(hand, Vec3::Zero(), Vec3::Zero(), 1e-3);
  EXPECT_LE((coupling.pose().position - hand.position).norm(), 1e-9);
  EXPECT_LE(coupling.pose().orientation.angularDistance(hand.orientation), 1e-7);
  EXPECT_LE(coupling.force().norm(), 1e-6);
}

TEST(VirtualCoupling, PassesAForceOnToTheHandUpToTheLimit) {
  const Vec3 push(0, 0, 2.0), twist(0.01, 0, 0);
  VirtualCoupling coupling({}, {});
  for (int k = 0; k < 3000; ++k) coupling.follow({}, push, twist, 1e-3);
  EXPECT_NEAR((coupling.force() - push).norm(), 0.0, 1e-6);
  EXPECT_NEAR((coupling.torque() - twist).norm(), 0.0, 1e-6);
  EXPECT_NEAR(coupling.pose().position.z(), 2.0 / 500.0, 1e-8);
  for (int k = 0; k < 3000; ++k) coupling.follow({}, 10.0 * push, twist, 1e-3);
  EXPECT_NEAR(coupling.force().norm(), 5.0, 1e-9);
}

TEST(VirtualCoupling, PassesATorqueOnToTheHandUpToItsOwnLimit) {
  VirtualCoupling coupling({.largest_force = 3.0, .largest_torque = 0.004}, {});
  for (int k = 0; k < 3000; ++k) coupling.follow({}, {0, 0, 4.0}, {0, 0.01, 0}, 1e-3);
  EXPECT_NEAR(coupling.force().norm(), 3.0, 1e-9);
  EXPECT_NEAR((coupling.torque() - Vec3(0, 0.004, 0)).norm(), 0.0, 1e-6);
}

/// A quaternion and its negative are one orientation.
TEST(VirtualCoupling, TurnsTheShorterWay) {
  const Quaternion turn(Eigen::AngleAxisd(0.4, Vec3(0.2, 1, 0).normalized()));
  const Quaternion negative(-turn.w(), -turn.x(), -turn.y(), -turn.z());
  VirtualCoupling one({}, {}), other({}, {});
  for (int k = 0; k < 500; ++k) {
    one.follow({.orientation = turn}, ToolForce{}, 1e-3);
    other.follow({.orientation = negative}, ToolForce{}, 1e-3);
    ASSERT_LE(other.pose().orientation.angularDistance(one.pose().orientation), 1e-7) << k;
    ASSERT_LE(other.pose().spin.norm(), one.pose().spin.norm() + 1e-6) << k;
  }
  EXPECT_LE(one.pose().orientation.angularDistance(turn), 0.05);
}

TEST(VirtualCoupling, IsStableHoweverStiff) {
  VirtualCoupling coupling({.stiffness = 1e9, .turning_stiffness = 1e7}, {});
  const ToolPose hand{.position = {0.1, 0, 0}};
  for (int k = 0; k < 100; ++k) {
    coupling.follow(hand, Vec3::Zero(), Vec3::Zero(), 1e-3);
    ASSERT_LE(coupling.pose().position.norm(), 0.1 * (1 + 1e-4));
  }
  EXPECT_NEAR(coupling.pose().position.x(), 0.1, 1e-6);
}

TEST(VirtualCoupling, RefusesWhatMakesNoSense) {
  EXPECT_TRUE(refuses([] { VirtualCoupling({.mass = 0.0}, {}); }, "mass (kg) above 0; got 0"));
  EXPECT_TRUE(refuses([] { VirtualCoupling({.stiffness = -1.0}, {}); }, "stiffness (N/m), 0 or more; got -1"));
}

/// A device that loses its bearings for a tick must not leave the tool without a place for good.
TEST(VirtualCoupling, LeavesOutATickThatIsNotFinite) {
  const ToolPose hand{.position = {0.01, 0, 0}, .velocity = {0.1, 0, 0}};
  VirtualCoupling coupling({}, {});
  for (int k = 0; k < 10; ++k) coupling.follow(hand, {0, 0, 1}, Vec3::Zero(), 1e-3);
  const ToolPose before = coupling.pose();
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
  follows({.orientation = {0, 0, 0, 0}}, none, none, 1e-3);
  follows({.velocity = {0, INFINITY, 0}}, none, none, 1e-3);
  follows({.spin = bad}, none, none, 1e-3);
  follows(hand, bad, none, 1e-3);
  follows(hand, none, bad, 1e-3);
  for (const double dt : {no_number, double{INFINITY}, -1e-3}) follows(hand, none, none, dt);
  follows({.position = {1e300, 0, 0}}, none, none, 1e-3);  // finite, but not its square
  for (int k = 0; k < 3000; ++k) coupling.follow(hand, none, none, 1e-3);
  EXPECT_TRUE(coupling.pose().position.allFinite());
  EXPECT_NEAR(coupling.pose().position.x(), hand.position.x() + 5.0 * 0.1 / 500.0, 1e-6);  // spring against damper
}

TEST(VirtualCoupling, StartsAnewWhereTheDeviceIs) {
  VirtualCoupling coupling({}, {});
  for (int k = 0; k < 10; ++k) coupling.follow({.position = {0.1, 0, 0}}, Vec3::Zero(), Vec3::Zero(), 1e-3);
  ASSERT_GT(coupling.force().norm(), 1.0);
  const ToolPose place{.position = {0, 0.2, 0}, .orientation = Quaternion(0, 2, 0, 0)};
  coupling.reset(place);
  EXPECT_EQ(coupling.pose().position, place.position);
  EXPECT_EQ(coupling.pose().orientation, Quaternion(0, 1, 0, 0));
  EXPECT_EQ(coupling.force(), Vec3(Vec3::Zero()));
  EXPECT_EQ(coupling.torque(), Vec3(Vec3::Zero()));
  coupling.follow(place, Vec3::Zero(), Vec3::Zero(), 1e-3);
  EXPECT_LE((coupling.pose().position - place.position).norm(), 1e-15);
  const ToolPose nowhere{.position = {std::nan(""), 0, 0}};
  const ToolPose unturned{.orientation = Quaternion(0, 0, 0, 0)};
  for (const ToolPose& pose : {nowhere, unturned}) {
    EXPECT_TRUE(refuses([&] { coupling.reset(pose); }, "expected a pose of finite numbers"));
    EXPECT_TRUE(refuses([&] { VirtualCoupling({}, pose); }, "expected a pose of finite"));
  }
  EXPECT_EQ(coupling.pose().position, place.position);
}

/// The loop of a haptic program at 1 kHz: a hand goes 4 mm into a block and rests there.
TEST(VirtualCoupling, HandPressingABlockFeelsASteadyForce) {
  const Model model = soft_block({0.03, 0.03, 0.03}, 4, 4, 4);
  Scene scene(model);
  ToolPose hand{.position = {0.015, 0.015, 0.041}};
  scene.fix("z0").add_tool("probe", {.shape = Sphere{0.01}, .pose = hand});
  const auto solver = make_solver("cpu", model, scene, {}, damped(20.0));
  const int steps = static_cast<int>(std::ceil(1e-3 / (0.5 * solver->stable_step())));
  VirtualCoupling coupling({}, hand);
  const ToolHandle probe = scene.tool("probe");
  double least = INFINITY, most = 0.0, jump = 0.0, before = 0.0;
  for (int k = 0; k < 1500; ++k) {
    hand.velocity = k < 200 ? Vec3(0, 0, -0.025) : Vec3(Vec3::Zero());
    hand.position += 1e-3 * hand.velocity;
    const ToolForce& on_tool = solver->tool_force(probe);
    probe.move_to(coupling.follow(hand, on_tool.mean_force, on_tool.mean_torque, 1e-3));
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

/// A rigid load as a solver's tool feels it: what its motion of the last tick cost.
struct RigidLoad {
  ToolForce felt;
  Vec3 velocity{0, 0, 0}, spin{0, 0, 0};

  void move(const ToolPose& tool, double dt) {
    felt.mean_force = felt.held_mass / dt * (velocity - tool.velocity);
    felt.mean_torque = felt.held_inertia * (spin - tool.spin) / dt;
    velocity = tool.velocity;
    spin = tool.spin;
  }
};

/// However much is held, tool and load move as one tool of both masses does.
TEST(VirtualCoupling, CarriesALoadAsItsOwnMass) {
  for (const double ratio : {0.5, 4.0, 40.0, 1e4}) {
    const CouplingOptions own;
    CouplingOptions both = own;
    both.mass *= 1.0 + ratio;
    both.inertia *= 1.0 + ratio;
    RigidLoad load;
    load.felt.held_mass = ratio * own.mass;
    load.felt.held_inertia = ratio * own.inertia * Mat3::Identity();
    VirtualCoupling light({own}, {}), heavy({both}, {});
    for (int k = 0; k < 2000; ++k) {
      const double dt = k % 7 == 0 ? 2e-3 : 1e-3;
      const ToolPose hand{.position = {0.01 * std::sin(0.01 * k), 0.02, 0},
                          .orientation = Quaternion(Eigen::AngleAxisd(0.3 * std::cos(0.013 * k), Vec3::UnitX()))};
      load.move(light.follow(hand, load.felt, dt), dt);
      const ToolPose& expected = heavy.follow(hand, Vec3::Zero(), Vec3::Zero(), dt);
      ASSERT_LE((light.pose().position - expected.position).norm(), 1e-9) << ratio << ' ' << k;
      ASSERT_LE(light.pose().orientation.angularDistance(expected.orientation), 1e-7) << ratio << ' ' << k;
    }
  }
}

/// A long load on a tool turned by a quarter: its inertia is told in the tool's frame, and turns with it.
TEST(VirtualCoupling, CarriesALongLoadOnATurnedTool) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 1)}) {
    const Quaternion quarter(Eigen::AngleAxisd(M_PI / 2, axis.normalized()));
    const ToolPose hand{.orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3(0.2, 0.5, 1).normalized())) * quarter};
    VirtualCoupling coupling({}, {.orientation = quarter});
    const double own = CouplingOptions{}.inertia;
    RigidLoad load;
    load.felt.held_mass = 1e-9;
    load.felt.held_inertia = Vec3(40.0 * own, 40.0 * own, 0.5 * own).asDiagonal();
    const Mat3 inertia = load.felt.held_inertia;
    for (int k = 0; k < 3000; ++k) {
      const Mat3 turn = coupling.pose().orientation.toRotationMatrix();
      const ToolPose& tool = coupling.follow(hand, load.felt, 1e-3);
      load.felt.mean_torque = turn * inertia * turn.transpose() * (load.spin - tool.spin) / 1e-3;
      load.spin = tool.spin;
    }
    EXPECT_LE(coupling.pose().orientation.angularDistance(hand.orientation), 1e-2);  // rad
  }
}

/// Point masses beside the tool's position, on a tool that is turned, moves and spins: what they, the tool, spring and
/// damper give each other in a tick is in balance, force and torque.
TEST(VirtualCoupling, CarriesALoadBesideItsPosition) {
  const CouplingOptions o;
  const double dt = 1e-3;
  const Quaternion turned(Eigen::AngleAxisd(1.1, Vec3(0.3, -0.7, 0.5).normalized()));
  const ToolPose start{
      .position = {0.01, -0.02, 0.03}, .orientation = turned, .velocity = {0.1, -0.2, 0.15}, .spin = {2, -3, 1}};
  const ToolPose hand{.position = {0.012, -0.019, 0.033}, .orientation = turned, .velocity = {0.05, 0.1, -0.1}};
  const VecList at{{0.03, 0.01, 0}, {0.02, -0.01, 0.04}, {0.01, 0.03, 0.02}};
  ToolForce load{.mean_force = {0.3, -0.2, 0.5}, .mean_torque = {0.01, 0.02, -0.03}};
  const double each = 2.0 * o.mass;
  for (const Vec3& q : at) {
    load.held_mass += each;
    load.held_centre += q / static_cast<double>(at.size());
    load.held_inertia += each * (q.squaredNorm() * Mat3::Identity() - q * q.transpose());
  }
  VirtualCoupling coupling(o, start);
  const ToolPose& tool = coupling.follow(hand, load, dt);
  const Vec3 dv = tool.velocity - start.velocity, dw = tool.spin - start.spin;
  const Vec3 pull = o.stiffness * (hand.position - start.position - dt * tool.velocity) +
                    o.damping * (hand.velocity - tool.velocity) + load.mean_force;
  const Vec3 twist = (-dt * o.turning_stiffness - o.turning_damping) * tool.spin + load.mean_torque;
  Vec3 momentum = o.mass * dv, angular = o.inertia * dw;
  for (const Vec3& q : at) {
    const Vec3 r = turned * q, change = each * (dv + dw.cross(r));
    momentum += change;
    angular += r.cross(change);
  }
  EXPECT_LE((momentum - dt * pull).norm(), 1e-12 * dt * pull.norm());
  EXPECT_LE((angular - dt * twist).norm(), 1e-12 * dt * twist.norm());
}

/// In a tick that is left out the tool stands still, and its load with it.
TEST(VirtualCoupling, CarriesALoadThroughATickLeftOut) {
  RigidLoad load;
  load.felt.held_mass = 40 * CouplingOptions{}.mass;
  VirtualCoupling coupling({}, {});
  const ToolPose hand{.position = {0.02, 0, 0}};
  for (int k = 0; k < 50; ++k) load.move(coupling.follow(hand, load.felt, 1e-3), 1e-3);
  const double speed = coupling.pose().velocity.norm();
  coupling.follow({.orientation = {0, 0, 0, 0}}, load.felt, 1e-3);
  load.move({}, 1e-3);
  load.move(coupling.follow(hand, load.felt, 1e-3), 1e-3);
  // The hand has stopped the load and left the light tool its momentum; a push by the load's would give 40 times that.
  EXPECT_LE(coupling.pose().velocity.norm(), 0.1 * speed);
}

/// To the bit, so that programs whose tools hold nothing go on as they were.
TEST(VirtualCoupling, WithoutALoadIsTheSpringAndTheDamperAlone) {
  const CouplingOptions o;
  VirtualCoupling coupling(o, {}), of_force(o, {});
  ToolPose tool;
  for (int k = 0; k < 500; ++k) {
    const double dt = 1e-3;
    const ToolPose hand{.position = {0.01 * std::sin(0.05 * k), 0.001 * k, 0}, .velocity = {0.1, 0, 0.2}};
    const ToolForce on_tool{.mean_force = {0.3, std::cos(0.1 * k), 0}, .mean_torque = {0, 0.01, 0}};
    const Vec3 pull = o.stiffness * (hand.position - tool.position) + o.damping * hand.velocity + on_tool.mean_force;
    tool.velocity = (o.mass * tool.velocity + dt * pull) / (o.mass + dt * o.damping + dt * dt * o.stiffness);
    tool.position += dt * tool.velocity;
    const ToolPose& went = coupling.follow(hand, on_tool, dt);
    ASSERT_EQ(went.position, tool.position);
    ASSERT_EQ(went.velocity, tool.velocity);
    ASSERT_EQ(of_force.follow(hand, on_tool.mean_force, on_tool.mean_torque, dt), went);
  }
}

/// A block that hangs on a jaw in a still hand; `turned`: the hand turns it by 0.3 rad about the upright axis.
struct Hanging {
  double weight = 0.0;                  // N
  double least = INFINITY, most = 0.0;  // N, downward to the hand in the last 0.2 s
  double off = 0.0;                     // rad from the hand's orientation at most, likewise
  double twist = 0.0;                   // N m, at most, likewise
  ToolForce held;
};

Hanging hang(const Tool& jaw, double grasp, double ratio, bool turned, double gravity) {
  const Model model = soft_block({0.03, 0.03, 0.03}, 5, 5, 5);
  Scene scene = Scene(model).gravity({0, 0, -gravity});
  scene.add_tool("jaw", jaw);
  const auto solver = make_solver("cpu", model, scene, {}, damped(20.0));
  const int steps = static_cast<int>(std::ceil(1e-3 / (0.5 * solver->stable_step())));
  const ToolHandle tool = scene.tool("jaw");
  tool.grasp(grasp);
  EXPECT_TRUE(solver->step(steps, 1e-3 / steps).ok());
  Hanging seen{.weight = gravity * total_mass(model), .held = solver->tool_force(tool)};
  CouplingOptions options_of_hand;
  (turned ? options_of_hand.inertia : options_of_hand.mass) =
      (turned ? seen.held.held_inertia(2, 2) : seen.held.held_mass) / ratio;
  // The damper, once a tick, adds to the inertia: one fit for this small a block is below it.
  if (turned) options_of_hand.turning_stiffness = 0.02, options_of_hand.turning_damping = 4e-4;
  VirtualCoupling coupling(options_of_hand, jaw.pose);
  ToolPose hand = jaw.pose;
  if (turned) hand.orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  for (int k = 0; k < 1000; ++k) {
    tool.move_to(coupling.follow(hand, solver->tool_force(tool), 1e-3));
    const StepReport report = solver->step(steps, 1e-3 / steps);
    EXPECT_TRUE(report.ok()) << report.message();
    if (!report.ok()) return seen;
    if (k < 800) continue;
    seen.least = std::min(seen.least, -coupling.force().z());
    seen.most = std::max(seen.most, -coupling.force().z());
    seen.off = std::max(seen.off, coupling.pose().orientation.angularDistance(hand.orientation));
    seen.twist = std::max(seen.twist, coupling.torque().norm());
  }
  return seen;
}

TEST(VirtualCoupling, AStillHandFeelsTheWeightOfWhatItHolds) {
  const Tool jaw{.shape = Box{{0.02, 0.02, 0.001}}, .pose = {.position = {0.015, 0.015, 0.0312}}};
  // One that holds 4 cm beside its position.
  const Tool rod{.shape = Capsule{0.004, 0.05},
                 .pose = {.position = {-0.02, 0.015, 0.03},
                          .orientation = Quaternion(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()))}};
  for (const double ratio : {4.0, 40.0}) {
    for (const auto& [tool, grasp] : {std::pair(jaw, 0.007), std::pair(rod, 0.012)}) {
      const Hanging seen = hang(tool, grasp, ratio, false, 9.81);
      EXPECT_GT(seen.held.held_mass, 0.2 * seen.weight / 9.81);
      EXPECT_NEAR(seen.least, seen.weight, 0.02 * seen.weight) << ratio;
      EXPECT_NEAR(seen.most, seen.weight, 0.02 * seen.weight) << ratio;
    }
  }
}

TEST(VirtualCoupling, AHandTurnsWhatItHolds) {
  const Tool jaw{.shape = Box{{0.02, 0.02, 0.001}}, .pose = {.position = {0.015, 0.015, 0.0312}}};
  for (const double ratio : {4.0, 40.0}) {
    const Hanging seen = hang(jaw, 0.007, ratio, true, 0.0);
    EXPECT_LE(seen.off, 1e-3) << ratio;
    EXPECT_LE(seen.twist, 1e-3) << ratio;
  }
}

/// What a tool pushes without holding comes a tick late all the same: the rule of virtual_coupling.h.
TEST(VirtualCoupling, IsCalmWhereItIsHeavierThanTheFaceItPushes) {
  const Model model = soft_block({0.06, 0.06, 0.06}, 5, 5, 5);
  const double face = 1000.0 * 0.06 * 0.06 * 0.006;  // kg: of half a spacing
  const auto largest_jump = [&](double mass) {
    Scene scene(model);
    ToolPose hand{.position = {0.03, 0.03, 0.0651}};
    scene.fix("z0").add_tool("plate", {.shape = Box{{0.05, 0.05, 0.005}}, .pose = hand, .friction = 0.3});
    const auto solver = make_solver("cpu", model, scene, {}, damped(20.0));
    const int steps = static_cast<int>(std::ceil(1e-3 / (0.5 * solver->stable_step())));
    VirtualCoupling coupling({.mass = mass, .inertia = 1e-3, .largest_force = 20.0}, hand);
    const ToolHandle plate = scene.tool("plate");
    double jump = 0.0, before = 0.0;
    for (int k = 0; k < 1500; ++k) {
      hand.velocity = k < 300 ? Vec3(0, 0, -0.02) : Vec3(Vec3::Zero());
      hand.position += 1e-3 * hand.velocity;
      plate.move_to(coupling.follow(hand, solver->tool_force(plate), 1e-3));
      EXPECT_TRUE(solver->step(steps, 1e-3 / steps).ok());
      const double force = coupling.force().z();
      if (k >= 1300) jump = std::max(jump, std::abs(force - before));
      before = force;
    }
    EXPECT_GT(before, 0.1);
    return jump;  // N from one tick to the next
  };
  const double with_damper = 1e-3 * CouplingOptions{}.damping;
  EXPECT_LE(largest_jump(1.2 * face - with_damper), 0.01);
  EXPECT_GT(largest_jump(0.5 * face - with_damper), 0.1);
}

/// CouplingOptions::damping / stiffness seconds behind a hand whose velocity is not told.
TEST(VirtualCoupling, LagsBehindAHandWhoseVelocityIsLeftOut) {
  const CouplingOptions o;
  for (const bool told : {false, true}) {
    VirtualCoupling coupling(o, {});
    ToolPose hand;
    for (int k = 0; k < 1000; ++k) {
      hand.position.x() += 1e-3 * 0.1;
      hand.velocity.x() = told ? 0.1 : 0.0;
      coupling.follow(hand, ToolForce{}, 1e-3);
    }
    const double lag = hand.position.x() - coupling.pose().position.x();
    EXPECT_NEAR(lag, told ? 0.0 : 0.1 * o.damping / o.stiffness, 1e-6);
  }
}

}  // namespace
}  // namespace phymul::test
