// SPDX-License-Identifier: MIT
//
// Simulation::solve_static in scenes with tools: the shape and forces that steps come to.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr double gravity = 9.81;

SimulationOptions soft_options(double poisson = 0.3) {
  SimulationOptions options;
  options.material = Material{.young = 10e3, .poisson = poisson, .density = 1000};
  options.backend = "reference";
  options.solver.rest_tolerance = 1e-9;
  return options;
}

/// A block of 8 x 8 x 5 cm on its lower side, with a tool above.
Simulation under(const Tool& tool, Model model = make_block({0.08, 0.08, 0.05}, 9, 9, 6), double poisson = 0.3) {
  Simulation sim(std::move(model), soft_options(poisson));
  sim.scene().fix("z0").add_tool("tool", tool);
  return sim;
}

struct Case {
  const char* name;
  Tool tool;
  bool tetrahedra = false;
};

std::vector<Case> cases() {
  const ToolPose ball{.position = {0.041, 0.039, 0.065}};
  const ToolPose edge{.position = {0.04, 0.04, 0.056}};
  const ToolPose lying{.position = {0.04, 0.01, 0.055},
                       .orientation = Quaternion(Eigen::Quaterniond::FromTwoVectors(Vec3(0, 0, 1), Vec3(0, 1, 0)))};
  return {{"sphere, particles", {.shape = Sphere{0.02}, .pose = ball}},
          {"sphere, surface", {.shape = Sphere{0.02}, .pose = ball, .contact = ToolContact::surface}},
          {"sphere, surface, tetrahedra", {.shape = Sphere{0.02}, .pose = ball, .contact = ToolContact::surface}, true},
          {"sphere, compliance", {.shape = Sphere{0.02}, .pose = ball, .compliance = 1e-3}},
          {"box, particles", {.shape = Box{{0.015, 0.015, 0.01}}, .pose = edge, .margin = 0.001}},
          {"capsule, surface", {.shape = Capsule{0.01, 0.06}, .pose = lying, .contact = ToolContact::surface}}};
}

/// m and m: by how much the body as a whole moved along x and y, and turned about z (as far as its corners go).
std::pair<double, double> slid_and_turned(const Simulation& sim) {
  const VecList& rest = sim.model().rest;
  const VecList position = sim.state().position;
  const Vec3 middle = sum(rest) / static_cast<double>(rest.size());
  Vec3 shift = Vec3::Zero(), moment = Vec3::Zero();
  double arms = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vec3 arm = rest[i] - middle, u = position[i] - rest[i];
    shift += u / static_cast<double>(rest.size());
    moment += arm.cross(u);
    arms += arm.head<2>().squaredNorm();
  }
  return {shift.head<2>().norm(), std::abs(moment.z()) / arms * 0.5 * body_size(sim.model())};
}

/// Between two frictionless plates that are tools; between two that are imposed motion, with a tool far away.
TEST(StaticTools, LeaveABodyWhereItIsFreeToSlide) {
  const Quaternion downward(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()));
  for (const bool plates_are_tools : {true, false}) {
    SCOPED_TRACE(plates_are_tools);
    Simulation sim(make_block({0.08, 0.08, 0.08}, 5, 5, 5), soft_options(0.45));
    if (plates_are_tools) {
      sim.scene().add_tool("below", {.shape = HalfSpace{}, .pose = {.position = {0, 0, 0.002}}});
      sim.scene().add_tool("above",
                           {.shape = HalfSpace{}, .pose = {.position = {0, 0, 0.078}, .orientation = downward}});
    } else {
      for (const auto& [group, by] : {std::pair{"z0", 0.0}, std::pair{"z1", 0.004}}) {
        sim.scene().add({.type = LoadType::translation,
                         .particles = sim.model().group(group),
                         .events = {{0.0, by}},
                         .axes = {Axis::free, Axis::free, by == 0.0 ? Axis::held : Axis::driven},
                         .direction = {0, 0, -1}});
      }
      sim.scene().add_tool("far", {.shape = Sphere{0.01}, .pose = {.position = {0, 0, 1}}});
    }
    const StaticResult result = sim.solve_static();
    ASSERT_TRUE(result.converged()) << result.message();
    EXPECT_LE(result.evaluations, 400);
    const auto [slid, turned] = slid_and_turned(sim);
    EXPECT_LT(slid, 1e-6);
    EXPECT_LT(turned, 1e-6);
    EXPECT_GT(sim.max_displacement(), 0.001);
  }
}

TEST(StaticTools, FindTheShapeAndForcesThatStepsComeTo) {
  for (const Case& own : cases()) {
    SCOPED_TRACE(own.name);
    const Model model = own.tetrahedra ? make_tetrahedral_block({0.08, 0.08, 0.05}, 9, 9, 6, 0.2, 1)
                                       : make_block({0.08, 0.08, 0.05}, 9, 9, 6);
    Simulation solved = under(own.tool, model), stepped = under(own.tool, model);
    const StaticResult result = solved.solve_static();
    ASSERT_TRUE(result.converged()) << result.message();
    EXPECT_LE(result.evaluations, 600);
    ASSERT_TRUE(has_converged(stepped.run_to_rest(20000)));
    // Steps take only so many rounds over the points of a surface.
    const bool surface = own.tool.contact == ToolContact::surface;
    EXPECT_LT(largest_distance(solved.state().position, stepped.state().position),
              (surface ? 0.05 : 1e-6) * stepped.max_displacement());
    const ToolForce& of_rest = solved.force_on(solved.scene().tool("tool"));
    const Vec3 force = of_rest.force, torque = of_rest.torque;
    EXPECT_EQ(of_rest.mean_force, force);
    const ToolForce& of_steps = stepped.force_on(stepped.scene().tool("tool"));
    EXPECT_GT(force.norm(), 0.5);
    const double bound = surface ? 0.03 : 1e-5;
    EXPECT_LT((force - of_steps.force).norm(), bound * force.norm());
    EXPECT_LT((torque - of_steps.torque).norm(), bound * torque.norm() + 1e-5 * force.norm());

    // The next step feels that force, and nothing moves.
    if (surface) continue;
    const State before = solved.state();
    solved.advance(1e-4);
    EXPECT_LT((solved.force_on(solved.scene().tool("tool")).force - force).norm(), 1e-3 * force.norm());
    EXPECT_LT(largest_distance(before.position, solved.state().position), 1e-4 * solved.max_displacement());
  }
}

/// A plate deep in an organ presses it as one that came in little by little does, and nearly as in steps.
TEST(StaticTools, APlateInTheBodyIsWhereItCameFrom) {
  const auto organ = [] {
    Simulation sim(make_body(solid_ellipsoid({0, 0, 0}, {0.03, 0.04, 0.015}), {.spacing = 7e-3}), soft_options(0.45));
    sim.scene().fix(sim.model().particles_in([](const Vec3& x) { return x.z() < -0.008; }));
    sim.scene().add_tool(
        "plate",
        {.shape = Box{{0.008, 0.008, 0.005}}, .pose = {.position = {0, 0, 0.02}}, .contact = ToolContact::surface});
    return sim;
  };
  const auto put = [](Simulation& sim, double by) {
    sim.scene().tool("plate").move_to({.position = {0, 0, 0.02 - by}});
  };
  const auto force = [](Simulation& sim) { return sim.force_on(sim.scene().tool("plate")).force.z(); };
  Simulation at_once = organ(), by_and_by = organ(), stepped = organ();
  for (const double by : {0.001, 0.002, 0.003, 0.004}) {
    put(by_and_by, by);
    ASSERT_TRUE(by_and_by.solve_static().converged());
    if (by != 0.002) continue;
    put(stepped, by);
    ASSERT_TRUE(is_ok(stepped.advance(0.05)));
    ASSERT_TRUE(has_converged(stepped.run_to_rest(20000)));
    EXPECT_NEAR(force(by_and_by), force(stepped), 0.02 * force(stepped));
  }
  put(at_once, 0.004);
  const StaticResult result = at_once.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  EXPECT_LE(result.evaluations, 1000);
  EXPECT_NEAR(force(at_once), force(by_and_by), 1e-3 * force(by_and_by));
}

/// Small steps too, in which rounds leave little: triangles over the edges of a box are pushed along their normals.
TEST(StaticTools, EdgesOfABoxHoldTissueInStepsAsAtRest) {
  for (const Model& block :
       {make_block({0.04, 0.04, 0.03}, 7, 7, 5), make_tetrahedral_block({0.04, 0.04, 0.03}, 7, 7, 5, 0.2, 1)}) {
    const auto pressed = [&] {
      SimulationOptions options = soft_options();
      options.backend = "cpu";
      options.damping.rate = 150.0;
      Simulation sim(block, options);
      const ToolPose pose{.position = {0.02, 0.02, 0.0375}};
      const Box box{{0.009, 0.009, 0.01}};
      sim.scene().fix("z0").add_tool("box", {.shape = box, .pose = pose, .contact = ToolContact::surface});
      return sim;
    };
    const auto force = [](Simulation& sim) { return sim.force_on(sim.scene().tool("box")).mean_force.z(); };
    Simulation solved = pressed();
    ASSERT_TRUE(solved.solve_static().converged());
    for (const double share : {0.5, 0.1}) {
      Simulation stepped = pressed();
      const double dt = share * stepped.step_limit();
      for (int k = 0; k < 5; ++k) ASSERT_TRUE(is_ok(stepped.step(static_cast<int>(0.02 / dt), dt)));
      EXPECT_NEAR(force(stepped), force(solved), 0.03 * force(solved)) << block.cells.size() << ' ' << share;
    }
  }
}

/// Triangles with one or two corners that are held bear a force like others.
TEST(StaticTools, ATriangleAtAHeldEdgeIsPressed) {
  const auto beside = [] {
    Simulation sim(make_block({0.06, 0.06, 0.04}, 6, 6, 4), soft_options());
    sim.scene().fix("x0").add_tool(
        "ball",
        {.shape = Sphere{0.008}, .pose = {.position = {0.006, 0.0311, 0.0465}}, .contact = ToolContact::surface});
    return sim;
  };
  Simulation solved = beside(), stepped = beside();
  const StaticResult result = solved.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  ASSERT_TRUE(has_converged(stepped.run_to_rest(20000)));
  const double force = stepped.force_on(stepped.scene().tool("ball")).force.z();
  EXPECT_GT(force, 0.05);
  // In steps a tool does not feel the share of corners that are held.
  EXPECT_GT(solved.force_on(solved.scene().tool("ball")).force.z(), 0.95 * force);
}

TEST(StaticTools, AFloorCarriesTheWeight) {
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    Simulation sim(make_tetrahedral_block({0.06, 0.06, 0.04}, 5, 5, 4, 0.2, 1), soft_options(0.45));
    sim.scene().gravity({0, 0, -gravity}).add_tool("floor", {.shape = HalfSpace{}, .contact = contact});
    const StaticResult result = sim.solve_static();
    ASSERT_TRUE(result.converged()) << result.message();
    double mass = 0.0;
    for (const double own : sim.model().mass) mass += own;
    const Vec3 force = sim.force_on(sim.scene().tool("floor")).force;
    EXPECT_NEAR(force.z(), -mass * gravity, 1e-5 * mass * gravity);
    EXPECT_LT(force.head<2>().norm(), 1e-5 * mass * gravity);
    EXPECT_GT(sim.max_displacement(), 1e-4);
  }
}

TEST(StaticTools, WhatAToolGraspsGoesWithIt) {
  const auto lifted = [] {
    Simulation sim = under({.shape = Sphere{0.01}, .pose = {.position = {0.04, 0.04, 0.058}}});
    const ToolHandle tool = sim.scene().tool("tool");
    tool.grasp(0.01);
    sim.scene().add_joint({at_tool("tool", {0, 0.01, 0}), at_mean(sim.model().group("x1")), 0.01}, 5.0);
    sim.advance(1e-3);
    EXPECT_GT(sim.state().tools.at(0).held.size(), 3u);
    tool.move_to({.position = {0.045, 0.04, 0.066}, .orientation = Quaternion(Eigen::AngleAxisd(0.2, Vec3::UnitX()))});
    return sim;
  };
  Simulation solved = lifted(), stepped = lifted();
  const StaticResult result = solved.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  ASSERT_TRUE(has_converged(stepped.run_to_rest(20000)));
  EXPECT_LT(largest_distance(solved.state().position, stepped.state().position), 1e-6 * stepped.max_displacement());
  EXPECT_EQ(solved.state().tools.at(0).held, stepped.state().tools.at(0).held);
  EXPECT_LT((solved.pose_of(solved.scene().tool("tool")).position - Vec3(0.045, 0.04, 0.066)).norm(), 1e-12);
  const auto felt = [](Simulation& sim) { return sim.force_on(sim.scene().tool("tool")); };
  EXPECT_GT(felt(solved).force.norm(), 0.1);
  EXPECT_LT((felt(solved).force - felt(stepped).force).norm(), 1e-4 * felt(stepped).force.norm());
  EXPECT_LT((felt(solved).torque - felt(stepped).torque).norm(), 1e-4 * felt(stepped).torque.norm());
  EXPECT_EQ(felt(solved).particles, felt(stepped).particles);
  EXPECT_GT(felt(stepped).held_mass, 0.0);
  EXPECT_EQ(felt(solved).held_mass, felt(stepped).held_mass);
  EXPECT_LT((felt(solved).held_inertia - felt(stepped).held_inertia).norm(), 1e-9 * felt(stepped).held_inertia.norm());
  const Vec3 force = felt(solved).force;
  ASSERT_TRUE(solved.step(0, 1e-4).ok());
  EXPECT_EQ(felt(solved).force, force) << "by no step";
}

TEST(StaticTools, TakeAsManyEvaluationsForALargeBodyAsForASmallOne) {
  for (const int cells : {8, 16}) {
    Simulation sim = under(cases()[0].tool, make_block({0.08, 0.08, 0.05}, cells + 1, cells + 1, 5 * cells / 8 + 1));
    const StaticResult result = sim.solve_static();
    EXPECT_TRUE(result.converged()) << result.message();
    EXPECT_LE(result.evaluations, 200) << cells;
  }
}

/// Here a contact begins late that is much stiffer than the body around it.
TEST(StaticTools, ANewContactDoesNotHoldUpTheSearch) {
  const Tool ball{.shape = Sphere{0.02}, .pose = {.position = {0.04455, 0.0351, 0.065}}};
  Simulation sim = under(ball, make_block({0.08, 0.08, 0.05}, 17, 17, 11));
  const StaticResult result = sim.solve_static();
  EXPECT_TRUE(result.converged()) << result.message();
  EXPECT_LE(result.evaluations, 250);
}

TEST(StaticTools, WhatHasNoSuchRestIsRefusedByName) {
  const Tool ball = cases()[0].tool;
  const auto refusal = [](Simulation sim) { return message_of([&] { (void)sim.solve_static(); }); };
  Tool rough = ball, moving = ball, springy = ball;
  rough.friction = 0.2;
  moving.pose.velocity = {0, 0, -0.01};
  springy.compliance = 1e-3;
  springy.contact = ToolContact::surface;
  EXPECT_NE(refusal(under(rough)).find("the tool \"tool\" has friction"), std::string::npos);
  EXPECT_NE(refusal(under(moving)).find("the tool \"tool\" has a velocity"), std::string::npos);
  EXPECT_NE(refusal(under(springy)).find("compliance and ToolContact::surface"), std::string::npos);
  EXPECT_NE(refusal(under({.shape = Needle{.length = 0.1, .radius = 1e-3}})).find("is a needle"), std::string::npos);
  Simulation grasping = under(ball);
  grasping.scene().tool("tool").grasp(0.01);
  EXPECT_NE(refusal(std::move(grasping)).find("is to grasp in the next step"), std::string::npos);
  Simulation holding = under(ball);
  const ToolHandle tool = holding.scene().tool("tool");
  tool.grasp(1e-6);  // of what it covers, which then stays inside
  ASSERT_TRUE(holding.advance(1e-3).ok());
  EXPECT_TRUE(holding.solve_static().converged());
  tool.grasp(0.01);
  EXPECT_NE(message_of([&] { (void)holding.solve_static(); }).find("is to grasp in"), std::string::npos);
  ASSERT_TRUE(holding.advance(1e-3).ok());
  EXPECT_TRUE(holding.solve_static().converged());
  EXPECT_GT(holding.solver().held(tool), 0);
  tool.grasp(0.02);
  EXPECT_NE(message_of([&] { (void)holding.solve_static(); }).find("is to grasp in"), std::string::npos);
  tool.release();
  EXPECT_NE(message_of([&] { (void)holding.solve_static(); }).find("is to release in"), std::string::npos);
}

}  // namespace
}  // namespace phymul::test
