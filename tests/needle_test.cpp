// SPDX-License-Identifier: MIT
//
// Needles: the force on the hub over a whole insertion, and that neither step nor mesh makes it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tool_backends.h"

namespace phymul::test {
namespace {

constexpr double side = 0.04, offset = 0.5e-3;  // m: of the block; of the tip above it at first

Needle thin_needle() {
  return {.length = 0.1,
          .radius = 0.6e-3,
          .puncture = 0.4,
          .cutting = 0.15,
          .static_friction = 12.0,
          .kinetic_friction = 10.0,
          .spread = 0.012};
}

/// A needle over the middle of a block whose bottom is held, off the lattice's lines.
struct Insertion {
  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
  double dt;
  ToolPose pose{.position = {0.0203, 0.0197, side + offset}};

  Insertion(const std::string& backend, int cells, double share, const Needle& needle = thin_needle())
      : model(gel(cells)), scene(model) {
    scene.fix("z0").add_tool("needle", {.shape = needle, .pose = pose, .friction = 0.5});
    SolverOptions options;
    options.damping.rate = 40.0;
    solver = make_solver(backend, model, scene, {}, options);
    dt = share * solver->stable_step();
  }
  static Model gel(int cells) {
    Model model = make_block({side, side, side}, cells, cells, cells);
    set_material(model, {.young = 10e3, .poisson = 0.45, .density = 1000.0});
    return model;
  }

  /// Mean force on the hub along the shaft over each of `parts` equal parts of the way; up is against insertion.
  std::vector<double> go(double depth, double speed, int parts) {
    const double from = pose.position.z(), to = side - depth;
    std::vector<double> force;
    for (int k = 1; k <= parts; ++k) {
      pose.position.z() = from + (to - from) * k / parts;
      scene.tool("needle").pose(pose);
      const double seconds = std::abs(to - from) / parts / speed;
      const StepReport report = solver->step(std::max(1, static_cast<int>(std::lround(seconds / dt))), dt);
      EXPECT_TRUE(report.ok()) << report.message();
      force.push_back(solver->tool_force("needle").mean_force.z());
    }
    return force;
  }
};

using NeedleIn = WithTools;
PHYMUL_WITH_NEEDLES(NeedleIn);

TEST_P(NeedleIn, ForceRisesDropsAtPunctureGrowsWithDepthAndTurnsOnWithdrawal) {
  Insertion needle(GetParam(), 6, 0.4);
  const std::vector<double> in = needle.go(0.025, 0.1, 51);  // half a millimetre each
  EXPECT_EQ(in[0], 0.0);                                     // not there yet
  EXPECT_LT(in[1], in[2]);
  const auto peak = std::max_element(in.begin(), in.begin() + 10);
  EXPECT_NEAR(*peak, 0.4, 0.06);  // a mean over half a millimetre: less than the puncture force itself
  EXPECT_LE(*peak, 0.4 + 1e-6);
  EXPECT_LT(*std::min_element(peak, in.begin() + 15), 0.55 * *peak);
  // Cutting and kinetic friction per metre, of the shaft that is in the tissue as that stands.
  const double slope = (in[50] - in[30]) / (20 * 0.0005);
  EXPECT_NEAR(slope, 10.0, 1.0);
  const State deep = needle.solver->read();
  ASSERT_TRUE(deep.tools.at(0).needle.punctured);
  EXPECT_NEAR(in[50], 0.15 + 10.0 * 0.025, 0.1 * 0.4);
  const std::vector<double> hold = needle.go(0.025, 0.1, 1);
  EXPECT_GT(hold[0], 0.15);  // it sticks: the tissue stays drawn in
  const std::vector<double> out = needle.go(-offset, 0.1, 51);
  EXPECT_NEAR(out[10], -10.0 * 0.020, 0.1 * 0.2 + 0.01);
  EXPECT_NEAR(out[30], -10.0 * 0.010, 0.1 * 0.1 + 0.01);
  EXPECT_NEAR(out[50], 0.0, 0.01);
  EXPECT_TRUE(needle.solver->read().tools[0].needle.hole.empty());
}

TEST_P(NeedleIn, TakesFromTheTissueWhatTheHubFeels) {
  Insertion needle(GetParam(), 6, 0.4);
  needle.scene.clear();  // nothing held, so that the body's momentum is the needle's doing alone
  needle.scene.add_tool("needle",
                        {.shape = thin_needle(),
                         .pose = {.position = needle.pose.position, .velocity = {0, 0, -0.8}, .spin = {0, 0, 9}},
                         .friction = 0.5});
  SolverOptions options;
  options.largest_push = std::numeric_limits<double>::infinity();
  const auto solver = make(needle.model, needle.scene, options);
  const double dt = 0.3 * solver->stable_step();
  double largest = 0.0;
  for (int k = 0; k < 120; ++k) {
    const Momentum before = solver->momentum();
    ASSERT_TRUE(solver->step(1, dt).ok());
    const double force = solver->tool_force("needle").force.norm();
    largest = std::max(largest, force);
    const Imbalance left = imbalance(before, solver->momentum(), *solver, {"needle"}, dt);
    const double noise = 1e3 * roundoff() * (force + total_mass(needle.model) * 1.0 / dt);
    EXPECT_LE(left.force.norm(), noise) << k;
    EXPECT_LE(left.torque.norm(), 0.05 * noise) << k;
  }
  EXPECT_GT(largest, 0.2);
  EXPECT_TRUE(solver->read().tools.at(0).needle.punctured);
}

/// Largest difference of two curves over the largest force of both.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0.0, most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference = std::max(difference, std::abs(a[k] - b[k]));
    most = std::max({most, std::abs(a[k]), std::abs(b[k])});
  }
  return difference / most;
}

std::vector<double> curve(int cells, double share) {
  Insertion needle("cpu", cells, share);
  std::vector<double> all = needle.go(0.020, 0.1, 20);
  const std::vector<double> out = needle.go(-offset, 0.1, 20);
  all.insert(all.end(), out.begin(), out.end());
  return all;
}

TEST(NeedleCurve, IsThatOfHalfTheStep) {
  EXPECT_LE(apart(curve(6, 0.5), curve(6, 0.25)), 0.1);
}

TEST(NeedleCurve, IsThatOfAFinerMesh) {
  EXPECT_LE(apart(curve(6, 0.5), curve(9, 0.5)), 0.1);
}

TEST(NeedleCurve, OfTheFastBackendIsThatOfTheReference) {
  std::vector<std::vector<double>> both;
  for (const char* backend : {"reference", "cpu"}) {
    Insertion needle(backend, 5, 0.5);
    both.push_back(needle.go(0.015, 0.2, 15));
  }
  EXPECT_LE(apart(both[0], both[1]), 0.01);
}

TEST(NeedleShaft, TurningTakesTheFrictionAlongIt) {
  Insertion needle("cpu", 6, 0.5);
  needle.go(0.02, 0.1, 10);
  const double still = needle.go(0.021, 0.02, 1).front();
  needle.pose.spin = {0, 0, 300};  // rad/s: 180 mm/s at the shaft's surface, against 20 mm/s along it
  needle.scene.tool("needle").place(needle.pose);
  needle.pose.velocity = {0, 0, -0.02};
  needle.scene.tool("needle").place(needle.pose);
  ASSERT_TRUE(needle.solver->step(static_cast<int>(0.1 / needle.dt), needle.dt).ok());
  const ToolForce turning = needle.solver->tool_force("needle");
  EXPECT_NEAR(still, 0.15 + 10 * 0.021, 0.05);
  EXPECT_LT(turning.mean_force.z(), 0.15 + 0.25 * 10 * 0.021);
  // Tissue against the turn: at most kinetic friction times length times radius.
  const double most = 10.0 * 0.024 * 0.6e-3;
  EXPECT_LT(turning.mean_torque.z(), -0.3 * most);
  EXPECT_GT(turning.mean_torque.z(), -1.1 * most);
}

TEST(NeedleShaft, DrawsTheTissueSideways) {
  Insertion needle("cpu", 6, 0.5);
  needle.go(0.02, 0.1, 10);
  const State before = needle.solver->read();
  needle.pose.position.x() += 0.003;
  needle.scene.tool("needle").pose(needle.pose);
  ASSERT_TRUE(needle.solver->step(static_cast<int>(0.5 / needle.dt), needle.dt).ok());
  const State after = needle.solver->read();
  const NeedleNode& skin = after.tools.at(0).needle.hole.at(0);
  double moved = 0.0;
  for (std::size_t k = 0; k < skin.particles.size(); ++k) {
    moved += skin.weights[k] * (after.position[skin.particles[k]] - before.position[skin.particles[k]]).x();
  }
  EXPECT_NEAR(moved, 0.003, 2e-4);
  EXPECT_LT(needle.solver->tool_force("needle").force.x(), -0.05);
}

TEST(NeedleShaft, BehindTheBodyTheTipIsFree) {
  Insertion needle("cpu", 5, 0.5);
  needle.go(side + 0.02, 0.2, 40);
  EXPECT_TRUE(needle.solver->read().tools.at(0).needle.through);
  const std::vector<double> on = needle.go(side + 0.03, 0.2, 5);
  EXPECT_NEAR(on.back(), 10.0 * side, 0.12 * 10.0 * side);  // friction alone, along the block's whole height
}

}  // namespace
}  // namespace phymul::test
