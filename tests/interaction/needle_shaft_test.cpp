// SPDX-License-Identifier: MIT
//
// Needles whose shaft bends: against beam theory, against the stiff one, and that no stiffness is too much.
#include <phymul/state_file.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "interaction/needle_path.h"
#include "support/allocation_count.h"
#include "support/message_of.h"
#include "support/needle_insertion.h"

namespace phymul::test {
namespace {

TEST(NeedleBeam, IsTheCantileverOfBeamTheory) {
  const Needle needle{.length = 0.12, .bending_stiffness = 2e-3};
  const double l = needle.length, ei = needle.bending_stiffness, force = 0.01;
  const std::vector<ShaftLoad> at_tip{{.along = 0.0, .x = force, .y = 0.0}};
  const VecList bent = shaft_points(needle, at_tip, 7);
  EXPECT_NEAR(bent[0].x(), force * l * l * l / (3 * ei), 1e-15);
  EXPECT_EQ(bent[6], Vec3(0, 0, l));
  const double slope = (bent[1].x() - bent[0].x()) / (bent[1].z() - bent[0].z());
  EXPECT_NEAR(slope, -force * l * l / (2 * ei), 0.02 * force * l * l / (2 * ei));
  // A load spread evenly, as n forces in the middles of n pieces: the error falls as 1 / n^2.
  double before = 0.0;
  for (const int n : {2, 4, 8, 16}) {
    std::vector<ShaftLoad> even;
    for (int k = 0; k < n; ++k) even.push_back({.along = l * (k + 0.5) / n, .x = 0.0, .y = force / n});
    const double exact = force * l * l * l / (8 * ei);
    const double error = std::abs(shaft_points(needle, even, 2)[0].y() - exact) / exact;
    if (n > 2) {
      EXPECT_NEAR(error, before / 4, 0.03 * before);
    }
    before = error;
  }
  EXPECT_LT(before, 1e-3);
  EXPECT_EQ(shaft_points({.length = 0.1}, at_tip, 2)[0], Vec3(0, 0, 0));
  EXPECT_NEAR(tube_bending_stiffness(0.635e-3, 0.42e-3), 0.0207, 1e-4);
  EXPECT_TRUE(refuses([] { tube_bending_stiffness(1e-3, 1e-3); }, "outer radius above an inner one"));
  EXPECT_TRUE(refuses([&] { shaft_points(needle, {}, 1); }, "2 places or more, got 1"));
}

/// Of a shaft that forces bend, near its tip.
TEST(NeedleBeam, ALineFromATipIsStraight) {
  const Vec3 tip(0.01, 0.02, 0.03), axis = Vec3(1, 2, 2) / 3.0, across = Vec3(2, 1, -2) / 3.0;
  const ShaftLine line(tip, axis);
  for (const double along : {-0.05, 0.0, 0.05}) {
    const Vec3 place = tip + along * axis, off = 0.01 * across;
    EXPECT_LT((line.place(along) - place).norm(), 1e-15);
    EXPECT_NEAR(line.along(place + off), along, 1e-15);
    EXPECT_LT((line.aside(place + off) - off).norm(), 1e-15);
    EXPECT_EQ(line.axis(along), axis);
  }
  EXPECT_EQ(line.round(), HUGE_VAL);
}

/// m: how far the skin's point of the hole is from where the shaft is said to be there, across the needle.
double skin_off_shaft(const Solver& solver, const ToolPose& pose) {
  const State state = solver.read();
  const Vec3 place = place_of(state.tools.at(0).needle.hole.at(0), state);
  const VecList shaft = solver.needle_points("needle", 2001);
  const Vec3 axis = pose.orientation * Vec3::UnitZ();
  const auto nearest =
      std::ranges::min_element(shaft, {}, [&](const Vec3& point) { return std::abs(axis.dot(point - place)); });
  const Vec3 off = place - *nearest;
  return (off - axis.dot(off) * axis).norm();
}

using BendingNeedleIn = WithTools;
PHYMUL_ON_EVERY_BACKEND(BendingNeedleIn);

/// A block that hangs on the needle alone: its weight is known, and acts in its middle.
TEST_P(BendingNeedleIn, BendsUnderAHangingBlockAsABeamDoes) {
  constexpr double edge = 0.01, g = 9.81;
  const Model model =
      with_material(make_block({edge, edge, edge}, 4, 4, 4), {.young = 40e3, .poisson = 0.45, .density = 1000.0});
  Needle needle = bending(1.6e-3);
  needle.spread = 0.004;
  Scene scene(model);
  ToolPose pose{.position = {0.0051, 0.0049, edge + 5e-4}};
  scene.fix("z0").add_tool("needle", {.shape = needle, .pose = pose});
  const auto solver = make(model, scene, damped(60.0));
  const double dt = 0.4 * solver->stable_step();
  const double depth = 0.008;
  pose.position.z() = edge - depth;
  scene.tool("needle").move_to(pose);
  ASSERT_TRUE(solver->step(static_cast<int>(0.1 / dt), dt).ok());
  ASSERT_TRUE(solver->read().tools[0].needle.punctured);
  scene.remove(0);
  scene.gravity({g, 0, 0});
  ASSERT_TRUE(solver->step(static_cast<int>(0.7 / dt), dt).ok());
  ASSERT_TRUE(solver->step(100, dt).ok());
  const double weight = total_mass(model) * g;
  const ToolForce force = solver->tool_force("needle");
  EXPECT_NEAR(force.mean_force.x(), weight, 2e-3 * weight);
  Vec3 middle = Vec3::Zero();
  const State state = solver->read();
  for (Index i = 0; i < model.particle_count(); ++i) middle += model.mass[i] * state.position[i];
  middle /= total_mass(model);
  const double a = needle.length - (middle.z() - pose.position.z());
  const double exact = weight * a * a * (3 * needle.length - a) / (6 * needle.bending_stiffness);
  EXPECT_GT(exact, 0.015 * needle.length);
  const double bent = solver->needle_points("needle", 9).front().x() - pose.position.x();
  RecordProperty("over_beam_theory", std::to_string(bent / exact));
  EXPECT_NEAR(bent, exact, 0.002 * exact);
  EXPECT_NEAR(middle.x() - 0.005, exact, 0.1 * exact);  // the block hangs where the shaft is, but for its own sag
  EXPECT_LT(skin_off_shaft(*solver, pose), 2e-3 * exact);
  // Torque about the unbent tip: the weight's, whose arm is the way up to the block.
  EXPECT_NEAR(force.mean_torque.y(), weight * (needle.length - a), 0.03 * weight * edge);
}

/// Hub 3 mm aside after an insertion: hub force, and how far the skin went.
struct Aside {
  Vec3 force{0, 0, 0};
  double tip = 0.0;  // m, where it is
};
Aside moved_aside(const std::string& backend, const Needle& shape, int cells = 5, double share = 0.5) {
  Insertion needle(backend, cells, share, shape);
  needle.go(0.02, 0.1, 10);
  needle.pose.position.x() += 0.003;
  needle.scene.tool("needle").move_to(needle.pose);
  EXPECT_TRUE(needle.solver->step(static_cast<int>(0.25 / needle.dt), needle.dt).ok());
  EXPECT_TRUE(needle.solver->step(50, needle.dt).ok());
  return {needle.solver->tool_force("needle").mean_force, needle.solver->needle_points("needle", 2)[0].x()};
}

TEST_P(BendingNeedleIn, IsTheStiffOneWhereItIsVeryStiffAndFollowsTheTissueWhereItIsSoft) {
  const Aside stiff = moved_aside(GetParam(), thin_needle()), very = moved_aside(GetParam(), bending(1e3));
  EXPECT_NEAR(very.force.x(), stiff.force.x(), 0.02 * std::abs(stiff.force.x()));
  EXPECT_NEAR(very.tip, stiff.tip, 1e-5);
  EXPECT_LT(stiff.force.x(), -0.05);
  const Aside steel = moved_aside(GetParam(), bending(5e-3)), soft = moved_aside(GetParam(), bending(1e-6));
  EXPECT_GT(steel.force.x(), 0.95 * very.force.x());
  EXPECT_LT(steel.tip, very.tip - 1e-4);
  EXPECT_NEAR(soft.tip, 0.0203, 1e-4);  // where it was
  EXPECT_LT(std::abs(soft.force.x()), 1e-3);
}

TEST(BendingNeedle, PressesAsideAsWithHalfTheStepAndOnAFinerMesh) {
  const Aside one = moved_aside("cpu", bending(5e-3), 6), half = moved_aside("cpu", bending(5e-3), 6, 0.25),
              fine = moved_aside("cpu", bending(5e-3), 12);
  EXPECT_LT(one.force.x(), -0.04);
  EXPECT_NEAR(half.force.x(), one.force.x(), 0.03 * std::abs(one.force.x()));
  EXPECT_NEAR(fine.force.x(), one.force.x(), 0.1 * std::abs(one.force.x()));
}

TEST(BendingNeedle, InAStraightInsertionHasTheStiffOnesCurve) {
  const auto curve = [](double stiffness) { return Insertion("cpu", 6, 0.5, bending(stiffness)).go_in_and_out(); };
  const std::vector<double> stiff = curve(0.0);
  for (const double stiffness : {1e-3, 1e3}) EXPECT_LE(apart(stiff, curve(stiffness)), 0.01) << stiffness;
}

TEST(BendingNeedle, IsPushedAsideByTissueThatAProbePressesFromTheSide) {
  const auto tip_after = [](double stiffness) {
    Insertion needle("cpu", 6, 0.5, bending(stiffness));
    needle.scene.add_tool("probe", {.shape = Sphere{0.012}, .pose = {.position = {-0.013, 0.02, 0.025}}});
    needle.go(0.025, 0.1, 10);
    needle.scene.tool("probe").move_to({.position = {-0.003, 0.02, 0.025}});
    EXPECT_TRUE(needle.solver->step(static_cast<int>(0.4 / needle.dt), needle.dt).ok());
    const VecList points = needle.solver->needle_points("needle", 41);
    EXPECT_EQ(points.back(), needle.pose.position + Vec3(0, 0, thin_needle().length));
    return points.front().x() - needle.pose.position.x();
  };
  const double stiff = tip_after(1e3), steel = tip_after(0.02), rod = tip_after(0.3);
  EXPECT_LT(std::abs(stiff), 1e-5);
  EXPECT_GT(rod, 2e-4);
  EXPECT_GT(steel, 2.0 * rod);
}

TEST_P(BendingNeedleIn, TakesFromTheTissueWhatTheHubFeels) {
  Insertion needle(GetParam(), 6, 0.4);
  needle.scene.clear();
  needle.scene.add_tool("needle",
                        {.shape = bending(2e-3),
                         .pose = {.position = needle.pose.position, .velocity = {0.3, -0.1, -0.8}, .spin = {1, 2, 0}},
                         .friction = 0.5});
  const auto solver = make(needle.model, needle.scene, uncut());
  const double dt = 0.3 * solver->stable_step();
  double bent = 0.0;
  for (int k = 0; k < 120; ++k) {
    balanced_step(*solver, {"needle"}, dt);
    // What bends the shaft is what its hub holds up.
    const ToolState tool = solver->read().tools.at(0);
    Vec3 across = Vec3::Zero();
    for (const ShaftLoad& load : tool.needle.shaft) across += Vec3(load.x, load.y, 0.0);
    Vec3 hub = tool.pose.orientation.conjugate() * solver->tool_force("needle").force;
    hub.z() = 0.0;
    // In double precision on the CPU backends whatever their own is; a device adds some hundred shares up.
    const double added = GetParam().starts_with("gl") ? 0x1p-24 * 100.0 : 1e-9;
    EXPECT_LE((hub - across).norm(), added * (1.0 + across.norm())) << k;
    bent = std::max(bent, (solver->needle_points("needle", 2)[0] - tool.pose.position).norm());
  }
  EXPECT_GT(bent, 1e-4);
}

/// Moves the hub at random for `calls` calls of 100 steps; true where all went well and the needle stayed with the
/// body.
bool shaken(Insertion& needle, int calls, std::uint32_t seed) {
  std::mt19937 bits(seed);
  for (int k = 0; k < calls; ++k) {
    const double z = 0.012 * uniform(bits), y = 0.004 * uniform(bits), x = 0.004 * uniform(bits);
    needle.pose.position = Vec3(0.0203, 0.0197, block_side - 0.015) + Vec3(x, y, z);
    const Vec3 turn = 0.1 * random_vector(bits, 3);
    needle.pose.orientation = Quaternion(1.0, turn.x(), turn.y(), turn.z()).normalized();
    needle.scene.tool("needle").move_to(needle.pose);
    const StepReport report = needle.solver->step(100, needle.dt);
    EXPECT_TRUE(report.ok()) << report.message();
    if (!report.ok() || report.max_speed > 25.0) return false;
  }
  return true;
}

TEST(BendingNeedle, OfAnyStiffnessIsStableInAHandThatShakes) {
  for (const double stiffness : {1e-6, 1e-4, 1e-2, 1.0, 1e3}) {
    Insertion needle("cpu", 4, 0.4, [&] {
      Needle shape = bending(stiffness);
      shape.spread = 0.015;
      return shape;
    }());
    ASSERT_TRUE(shaken(needle, 50, 11)) << stiffness;
    const StepReport still = needle.solver->step(static_cast<int>(1.0 / needle.dt), needle.dt);
    ASSERT_TRUE(still.ok());
    EXPECT_LT(still.max_speed, 1e-3) << stiffness;
    for (const Vec3& x : needle.solver->read().position) EXPECT_LT((x - Vec3(0.02, 0.02, 0.02)).norm(), 0.06);
  }
}

/// Of a needle that is put 1 cm deep at once and moved aside, its last node where the tip is: the place of each
/// particle in the end, from a start of which one is moved by `way`.
VecList ends_from(const std::string& backend, double stiffness, double way) {
  const Model model = Insertion::gel(3);
  ToolPose pose{.position = {0.0203, 0.0197, block_side - 0.01}};
  Scene scene = Scene(model).fix("z0");
  scene.add_tool("needle", {.shape = bending(stiffness), .pose = pose, .friction = 0.5});
  const auto solver = make_solver(backend, model, scene, {}, damped(40.0));
  State start = solver->read();
  start.position[model.rest.size() / 2].x() += way;
  solver->reset(start);
  for (int k = 0; k < 4; ++k) {
    pose.position.x() += 4e-4;
    scene.tool("needle").move_to(pose);
    EXPECT_TRUE(solver->step(25, 0.4 * solver->stable_step()).ok());
  }
  return solver->read().position;
}

TEST_P(BendingNeedleIn, RoundingDoesNotDecideWhoHoldsTheTip) {
  const double way = GetParam() == "reference" ? 1e-12 : 1e-8;       // m
  for (const double stiffness : {0.0, 5e-3, 1.0}) {                  // 0: stiff
    if (stiffness == 1.0 && GetParam().starts_with("gl")) continue;  // takes a device as long again
    const VecList ends = ends_from(GetParam(), stiffness, 0.0);
    double most = 0.0;
    for (const double moved : {-way, way}) {
      if (moved < 0.0 && GetParam().starts_with("gl")) continue;  // likewise
      const VecList others = ends_from(GetParam(), stiffness, moved);
      most = std::max(most, largest_distance(others, ends));
    }
    RecordProperty("apart_at_" + std::to_string(stiffness), std::to_string(most / way));
    EXPECT_LE(most, 10.0 * way) << stiffness;
  }
}

TEST_P(BendingNeedleIn, GoesOnBitForBitFromAFile) {
  Insertion needle(GetParam(), 4, 0.4, bending(1e-3));
  const int calls = GetParam() == "gl" ? 5 : 15;  // draws take a processor longer
  ASSERT_TRUE(shaken(needle, calls, 5));
  const std::string path = testing::TempDir() + "bent_" + GetParam() + ".state";
  save_state(*needle.solver, path);
  const VecList shape = needle.solver->needle_points("needle", 5);
  EXPECT_GT((shape[0] - needle.pose.position).norm(), 1e-5);
  ASSERT_TRUE(shaken(needle, calls, 6));
  const State once = needle.solver->read();
  load_state(*needle.solver, path);
  EXPECT_EQ(needle.solver->needle_points("needle", 5), shape);
  ASSERT_TRUE(shaken(needle, calls, 6));
  EXPECT_EQ(needle.solver->read(), once);
}

TEST_P(BendingNeedleIn, RefusesAStateWhoseForcesAreNoForces) {
  Insertion needle(GetParam(), 5, 0.4, bending(1e-3));
  needle.go(0.02, 0.2, 5);
  State state = needle.solver->read();
  const auto refused = [&](const ShaftLoad& load) {
    state.tools.at(0).needle.shaft = {load};
    return message_of([&] { needle.solver->reset(state); }).find("numbers that no tool has") != std::string::npos;
  };
  EXPECT_FALSE(refused({0.01, 1.0, 2.0}));
  EXPECT_TRUE(refused({NAN, 1.0, 2.0}));
  EXPECT_TRUE(refused({1e9, 1.0, 2.0}));
  EXPECT_TRUE(refused({0.01, INFINITY, 2.0}));
  EXPECT_TRUE(refused({0.01, 1.0, NAN}));
  EXPECT_TRUE(refused({0.01, 1e308, 0.0}));
  EXPECT_FALSE(refused({0.01, 1.0, 2.0}));
  state.tools.at(0).needle.hole.at(0).weights.at(0) += 1.0;
  EXPECT_TRUE(refused({0.01, 1.0, 2.0})) << "weights of a mean";
}

TEST_P(BendingNeedleIn, AllocatesNothingAtADepthThatItHasReached) {
  Insertion needle(GetParam(), 5, 0.4, bending(1e-3));
  needle.go(0.02, 0.2, 5);
  needle.go(0.019, 0.2, 2);
  const std::size_t before = allocation_count();
  bool ok = true;
  for (int k = 0; k < 20; ++k) {
    needle.pose.position.x() += 1e-4;
    needle.pose.position.z() += k % 2 == 0 ? 5e-4 : -5e-4;  // nodes come and go from the shaft
    needle.scene.tool("needle").move_to(needle.pose);
    ok = ok && needle.solver->step(3, needle.dt).ok();
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_TRUE(ok);
}

TEST(BendingNeedle, IsAskedForByNameAndMustBeANeedle) {
  Insertion needle("cpu", 3, 0.4);
  needle.scene.add_tool("ball", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}}});
  EXPECT_TRUE(refuses([&] { needle.solver->needle_points("ball", 3); }, "expected a needle"));
  EXPECT_TRUE(refuses([&] { needle.solver->needle_points("x", 3); }, "no tool \"x\""));
  EXPECT_EQ(needle.solver->needle_points("needle", 2)[0], needle.pose.position);  // straight, before any step
  EXPECT_TRUE(refuses([&] { needle.scene.add_tool("bad", {.shape = bending(-1.0)}); }, "bending stiffness"));
}

}  // namespace
}  // namespace phymul::test
