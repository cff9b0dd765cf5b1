// SPDX-License-Identifier: MIT
//
// Joints between bodies, to tools and over patches of a surface: momentum, forces, glue.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "interaction/joint_set.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

using JointOfBodiesIn = WithTools;
PHYMUL_ON_EVERY_BACKEND(JointOfBodiesIn);

TEST_P(JointOfBodiesIn, KeepsMomentum) {
  const Model model = cubes_apart(0.002);
  Scene scene(model);
  scene.attach(model.group("upper/z0"), "lower", {.stiffness = 1e6});
  Joint rope{.springs = {}, .stiffness = 20.0, .damping = 0.01};
  rope.springs.push_back({at_mean(model.group("lower/x0")), at_mean(model.group("upper/z1")), 0.01});
  scene.add_joint("rope", rope);
  const auto solver = make_solver(GetParam(), model, scene);
  State state = rest_state(model);
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    state.velocity[i] = Vec3(0.3, 0, 0.1) + Vec3(5, 20, -10).cross(model.rest[i]);
  }
  solver->reset(state);
  const Momentum before = solver->momentum();
  ASSERT_TRUE(solver->step(400, 0.4 * solver->stable_step()).ok());
  const Momentum after = solver->momentum();
  EXPECT_GT(solver->joint_report("rope").force.norm(), 0.05) << "or this shows nothing";
  EXPECT_GT(solver->joint_report("joint 1").largest, 0.01);
  EXPECT_LT((after.linear - before.linear).norm(), 1e4 * roundoff() * before.linear.norm());
  EXPECT_LT((after.angular - before.angular).norm(), 1e4 * roundoff() * before.angular.norm());
}

/// A tool moves in space, a plane body does not: what is off its plane neither pulls nor lengthens a spring.
TEST_P(JointOfBodiesIn, OfAPlaneBodyPullInItsPlane) {
  const Model model = with_material(make_strip(0.02, 0.02, 2, 2));
  Scene scene = Scene(model).fix("x0");
  scene.add_tool("hook", {.shape = Sphere{0.001}, .pose = {.position = {0.023, 0.024, 0.005}}});
  const Index corner = 8;
  ASSERT_EQ(model.rest[corner], Vec3(0.02, 0.02, 0));
  scene.add_joint("rope", {.springs = {{at_particle(corner), at_tool("hook"), 0.0}}, .stiffness = 2.0});
  scene.add_joint("loose", {.springs = {{at_particle(corner), at_tool("hook")}}, .stiffness = 2.0});
  const auto solver = make_solver(GetParam(), model, scene);
  ASSERT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok());
  EXPECT_NEAR(solver->joint_report("rope").springs[0].length, 0.005, 1e-4 * 0.005);
  const Vec3 force = solver->tool_force("hook").force;
  EXPECT_NEAR(force.norm(), 0.01, 1e-4 * 0.01);
  EXPECT_EQ(force.z(), 0.0);
  EXPECT_NEAR(scene.joint("loose").joint().springs[0].rest_length, 0.005, 1e-12);
}

TEST_P(JointOfBodiesIn, GlueHoldsTwoCubesTogether) {
  const double gap = 0.001, pull = 0.4, k = 5e7;
  const Model model = cubes_apart(gap);
  Scene scene = Scene(model).fix("lower/z0");
  const JointHandle glue = scene.attach(model.group("upper/z0"), "lower", {.stiffness = k});
  Load load{.type = LoadType::force, .particles = model.group("upper/z1")};
  load.axes.fill(Axis::driven);
  load.events = {{0.0, pull / 16.0}};
  load.direction = {0.6, 0, 0.8};
  scene.add(load);
  const auto solver = make_solver(GetParam(), model, scene, {}, {.damping = {.rate = 60.0}, .rest_tolerance = 1e-7});
  ASSERT_TRUE(has_converged(solver->run_to_rest(100'000, 0.5 * solver->stable_step())));
  const JointReport& report = solver->joint_report(glue);
  ASSERT_EQ(report.springs.size(), 16u);
  EXPECT_LT((report.force + pull * Vec3(0.6, 0, 0.8)).norm(), 2e-3 * pull);
  // The mean opening is that of the stress; each spring's is k times its area.
  Vec3 mean = Vec3::Zero();
  for (std::size_t row = 0; row < report.springs.size(); ++row) {
    mean -= report.springs[row].force / k / (cubes_edge * cubes_edge);
    EXPECT_LT(report.springs[row].length, 0.002 * cubes_edge) << row;
  }
  EXPECT_NEAR(mean.norm() / (pull / k / (cubes_edge * cubes_edge)), 1.0, 2e-3);
}

TEST_P(JointOfBodiesIn, GlueTurnsWithItsBodies) {
  const Model model = cubes_apart(0.002);
  Scene scene(model);
  const JointHandle glue = scene.attach(model.group("upper/z0"), "lower", {.stiffness = 1e6});
  const auto solver = make_solver(GetParam(), model, scene);
  State state = rest_state(model);
  state.position = rigidly_moved(model, 7);
  solver->reset(state);
  ASSERT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok());
  EXPECT_LT(solver->joint_report(glue).largest, 1e3 * roundoff()) << "a turn of both, with the gap";
}

TEST_P(JointOfBodiesIn, APatchHasTheStiffnessOfItsArea) {
  const Model model = with_material(make_block({0.06, 0.04, 0.02}, 6, 4, 2));
  Scene scene(model);
  const double k = 3e5, shift = 1e-4;
  const JointHandle bed = scene.attach(model.group("z0"), World{}, {.stiffness = k});
  double sum = 0.0;
  for (const JointSpring& spring : bed.joint().springs) sum += spring.share;
  EXPECT_NEAR(sum, 0.06 * 0.04, 1e-15);
  EXPECT_EQ(bed.joint().springs.size(), 35u);
  const auto solver = make_solver(GetParam(), model, scene);
  State state = rest_state(model);
  for (Vec3& x : state.position) x += Vec3(shift, 2 * shift, -shift);
  solver->reset(state);
  ASSERT_TRUE(solver->step(1, 0.01 * solver->stable_step()).ok());
  const Vec3 force = solver->joint_report(bed).force;
  EXPECT_LT((force + k * 0.06 * 0.04 * Vec3(shift, 2 * shift, -shift)).norm(), 1e-4 * force.norm());
}

TEST_P(JointOfBodiesIn, ALigamentIsParallelFibres) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  Scene scene(model);
  const JointHandle ligament =
      scene.attach(model.group("z1"), World{{0, 0, 0.03}}, {.stiffness = 1e5, .slack = true, .name = "ligament"});
  EXPECT_EQ(ligament.joint().springs.front().rest_length, 0.03);
  const auto solver = make_solver(GetParam(), model, scene);
  const auto force_after = [&](const Vec3& shift) {
    State state = rest_state(model);
    for (Vec3& x : state.position) x += shift;
    solver->reset(state);
    EXPECT_TRUE(solver->step(1, 0.01 * solver->stable_step()).ok());
    return solver->joint_report("ligament").force;
  };
  EXPECT_NEAR(force_after({0, 0, -0.001}).z(), 1e5 * 4e-4 * 0.001, 1e-5);
  EXPECT_EQ(force_after({0, 0, 0.001}), Vec3(0, 0, 0));
  EXPECT_LT(force_after({0.001, 0, 0}).norm(), 1e-3) << "sideways a fibre gives way";
}

TEST_P(JointOfBodiesIn, AToolFeelsWhatItPulls) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 3, 3, 3));
  Scene scene(model);
  const ToolHandle tool = scene.add_tool(
      {.shape = Sphere{0.001}, .pose = {.position = {0.01, 0.005, 0.04}, .orientation = {0.8, 0.6, 0, 0}}});
  const JointHandle joint = scene.attach(model.group("z1"), tool, {.stiffness = 2e5});
  scene.add_joint({at_mean(model.group("x0")), at_tool("tool 1", {0, 0.002, 0})}, 3.0);
  const auto solver = make_solver(GetParam(), model, scene);
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_LT(solver->joint_report(joint).largest, 1e4 * roundoff()) << "attached without force";
  tool.move_to({.position = {0.011, 0.005, 0.042}, .orientation = {0.8, 0.59, 0.1, 0}});
  ASSERT_TRUE(solver->step(300, dt).ok());
  for (int step = 0; step < 5; ++step) {
    const Momentum before = solver->momentum();
    ASSERT_TRUE(solver->step(1, dt).ok());
    const Imbalance left = imbalance(before, solver->momentum(), *solver, {"tool 1"}, dt);
    const Vec3 pull = solver->joint_report(joint).force + solver->joint_report("joint 2").force;
    EXPECT_GT(pull.norm(), 0.005);
    EXPECT_LT((solver->tool_force(tool).force + pull).norm(), 1e-12) << "equal and opposite";
    const double change = total_mass(model) * 0.3 / dt;  // of momentum, that rounding is a part of
    EXPECT_LT(left.force.norm(), 10.0 * roundoff() * change);
    EXPECT_LT(left.torque.norm(), 10.0 * roundoff() * change * 0.05);
  }
  EXPECT_TRUE(solver->step(0, dt).ok());
  scene.remove_joint("joint 1").remove_joint("joint 2").remove_tool("tool 1");
  EXPECT_TRUE(solver->step(1, dt).ok());
}

TEST_P(JointOfBodiesIn, AToolWithoutJointsFeelsNothingOfThem) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  Scene scene(model);
  const ToolHandle tool = scene.add_tool({.shape = Sphere{0.001}, .pose = {.position = {0, 0, 0.05}}});
  scene.add_joint({at_mean(model.group("z1")), at_tool("tool 1"), 0.01}, 3.0);
  const auto solver = make_solver(GetParam(), model, scene);
  ASSERT_TRUE(solver->step(1, 1e-5).ok());
  EXPECT_GT(solver->tool_force(tool).force.norm(), 0.01);
  scene.remove_joint("joint 1");
  ASSERT_TRUE(solver->step(1, 1e-5).ok());
  EXPECT_EQ(solver->tool_force(tool).force, Vec3(0, 0, 0));
}

TEST_P(JointOfBodiesIn, AnImposedCoordinateTakesNoForce) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  Scene scene = Scene(model).fix("z0");
  scene.add_joint({at_mean(model.group("z0")), at_world({0.01, 0.01, -1}), 0.5}, 100.0);
  const auto solver = make_solver(GetParam(), model, scene);
  const StepReport report = solver->step(10, 0.5 * solver->stable_step());
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(solver->read().position, model.rest);
  EXPECT_EQ(report.residual, 0.0);
  EXPECT_NEAR(solver->joint_report("joint 1").force.z(), -50.0, 1e-3);
}

/// Of glued cubes, 200 steps on.
State glued_end(const std::string& backend, int threads = 0) {
  const Model model = cubes_apart(0.001);
  Scene scene = Scene(model).fix("lower/z0").gravity({1, 0, 9.81});
  scene.attach(model.group("upper/z0"), "lower", {.stiffness = 1e5, .damping = 50.0});
  const auto solver = make_solver(backend, model, scene, {}, {.threads = threads});
  EXPECT_TRUE(is_ok(solver->step(200, 0.5 * solver->stable_step())));
  return solver->read();
}

TEST(JointsOnTheProcessor, HaveTheSameBitsForAnyNumberOfThreads) {
  const State one = glued_end("cpu", 1);
  for (const int threads : {2, 3}) EXPECT_EQ(glued_end("cpu", threads), one);
}

TEST(JointsOnTheProcessor, AgreeWithTheReference) {
  EXPECT_LT(largest_distance(glued_end("reference").position, glued_end("cpu").position), 1e-7);
}

// What joints add to the step limit, beside the eigenvalues of their matrices.

using Matrix = Eigen::MatrixXd;

/// Largest eigenvalue of M^-1 K of springs without a rest length, along one axis.
double largest_eigenvalue(const Scene& scene, const std::vector<double>& mass) {
  const auto n = static_cast<Eigen::Index>(mass.size());
  Matrix K = Matrix::Zero(n, n);
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
      for (std::size_t k = 0; k < spring.a.particles.size(); ++k) row[spring.a.particles[k]] += spring.a.weights[k];
      for (std::size_t k = 0; k < spring.b.particles.size(); ++k) row[spring.b.particles[k]] -= spring.b.weights[k];
      K += joint.joint.stiffness * spring.share * row * row.transpose();
    }
  }
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = 1.0 / std::sqrt(mass[i]);
  return Eigen::SelfAdjointEigenSolver<Matrix>(scale.asDiagonal() * K * scale.asDiagonal()).eigenvalues().maxCoeff();
}

Anchor some_particles(std::mt19937& random, Index first, Index count) {
  std::uniform_real_distribution<double> weight(-0.5, 1.5);
  Anchor anchor;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    anchor.particles.push_back(first + (static_cast<Index>(random() % 1000) + k * 7) % (count / 3) * 3 + k);
    anchor.weights.push_back(k < 2 ? weight(random) : 1.0 - sum);
    sum += anchor.weights.back();
  }
  return anchor;
}

TEST(JointBounds, AreBoundsForWeightsOfBothSigns) {
  std::mt19937 random(5);
  Model model = make_block({0.02, 0.02, 0.01}, 2, 2, 1);
  for (double& mass : model.mass) mass = std::exp(std::uniform_real_distribution<double>(-3, 3)(random));
  for (int trial = 0; trial < 50; ++trial) {
    Scene scene(model);
    for (int k = 0; k < 3; ++k) {
      Joint joint{.stiffness = std::exp(std::uniform_real_distribution<double>(-6, 6)(random))};
      for (int spring = 0; spring < 3; ++spring) {
        joint.springs.push_back({some_particles(random, 0, 9), some_particles(random, 9, 9), 0.0});
      }
      scene.add_joint(joint);
    }
    const double bound = JointSet().bounds(scene, model.mass).stiffness;
    EXPECT_GE(bound, largest_eigenvalue(scene, model.mass) * (1.0 - 1e-12)) << trial;
  }
}

/// A patch on the world: with x = 1 alone the bound would be set by the lightest particle.
TEST(JointBounds, OfAPatchAreCloseToTheEigenvalue) {
  Model model = make_block({0.06, 0.06, 0.02}, 6, 6, 2);
  set_material(model, {.young = 1e4, .poisson = 0.3, .density = 1000});
  Scene scene(model);
  const std::vector<Index> face = model.group("z0");
  Joint joint{.stiffness = 100.0};
  for (std::size_t k = 0; k + 8 < face.size(); ++k) {
    joint.springs.push_back({at_mean({face[k], face[k + 1], face[k + 7], face[k + 8]}), at_world({0, 0, 0}), 0.0});
  }
  scene.add_joint(joint);
  const double exact = largest_eigenvalue(scene, model.mass);
  const double bound = JointSet().bounds(scene, model.mass).stiffness;
  EXPECT_GE(bound, exact * (1.0 - 1e-12));
  EXPECT_LE(bound, 1.15 * exact);
}

TEST(JointBounds, BeyondAllNumbersAreInfinite) {
  const Model model = make_block({0.02, 0.02, 0.01}, 2, 2, 1);
  for (const double stiffness : {0.0, 1e-300, 1e300, 1e308}) {
    Scene scene(model);
    const JointHandle joint = scene.add_joint({at_mean({0, 1}), at_world({0, 0, 1})}, 1.0);
    JointSet set;
    set.bounds(scene, model.mass);
    joint.set_stiffness(stiffness, 0.0);
    const double wanted = largest_eigenvalue(scene, model.mass);
    EXPECT_GE(set.bounds(scene, model.mass).stiffness, wanted * (1.0 - 1e-12)) << stiffness;
  }
}

}  // namespace
}  // namespace phymul::test
