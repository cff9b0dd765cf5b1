// SPDX-License-Identifier: MIT
//
// Tools of a scene: what is accepted, how they move, what they hold, and what they cost.
#include <cmath>
#include <limits>

#include "support/allocation_count.h"
#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

TEST(Tool, WhatMakesNoSenseIsRefusedByName) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  scene.add_tool("probe", {.shape = Sphere{0.002}});
  const auto message = [&](const std::string& name, const Tool& tool) {
    return message_of([&] { scene.add_tool(name, tool); });
  };
  EXPECT_TRUE(says(message("probe", {.shape = Sphere{1.0}}), "tool \"probe\": there is one of that name"));
  EXPECT_TRUE(says(message("", {.shape = Sphere{1.0}}), "expected a name"));
  EXPECT_TRUE(says(message("a", {.shape = Sphere{0.0}}), "expected a radius above 0 m, got 0"));
  EXPECT_TRUE(says(message("a", {.shape = Box{{1, -1, 1}}}), "half size above 0 m, got -1"));
  EXPECT_TRUE(says(message("a", {.shape = HalfSpace{}, .friction = -0.5}), "friction, 0 or more; got -0.5"));
  EXPECT_TRUE(
      says(message("a", {.shape = std::shared_ptr<const DistanceGrid>{}}), "expected a distance grid, got none"));
  EXPECT_TRUE(says(message("a", {.shape = Sphere{1.0}, .pose = {.position = {NAN, 0, 0}}}), "pose of finite numbers"));
  EXPECT_TRUE(says(message("a", {.shape = Sphere{1.0}, .pose = {.orientation = {0, 0, 0, 0}}}), "not zero"));
  EXPECT_TRUE(says(message("a", {.shape = Needle{.puncture = 1.0, .cutting = 2.0}}), "at most the puncture force 1 N"));
  EXPECT_TRUE(
      says(message("a", {.shape = Needle{.spread = 0.9e-3}}),
           "expected a spread of 0 (34 radii, at least two spacings), or of at least a tenth of this body's spacing"));
  EXPECT_TRUE(refuses([&] { scene.tool("needle"); }, "no tool \"needle\"; it has: probe"));
  EXPECT_EQ(scene.tools().size(), 1u);
  const ToolHandle handle = scene.tool("probe");
  scene.remove_tool("probe");
  EXPECT_TRUE(refuses([&] { handle.move_to({}); }, "no longer has the tool"));
}

TEST(Tool, PosesDoNotMakeTheSceneNew) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  const std::uint64_t empty = scene.version();
  scene.add_tool("probe", {.shape = Sphere{0.002}});
  const std::uint64_t version = scene.version();
  EXPECT_NE(version, empty);
  scene.tool("probe").move_to({.position = {1, 2, 3}});
  scene.tool("probe").grasp(0.001);
  EXPECT_EQ(scene.version(), version);
  EXPECT_EQ(scene.tool("probe").target_pose().position, Vec3(1, 2, 3));
  scene.remove_tool("probe");
  EXPECT_NE(scene.version(), version);
}

/// What a tool says that it holds is what its state says.
void expect_weighed(const ToolForce& force, const ToolState& state, const Model& model) {
  double mass = 0.0;
  Vec3 centre = Vec3::Zero();
  for (const Index i : state.held) mass += model.mass[i];
  for (std::size_t k = 0; k < state.held.size(); ++k) centre += model.mass[state.held[k]] / mass * state.held_at[k];
  EXPECT_NEAR(force.held_mass, mass, 1e-12 * mass);
  EXPECT_LE((force.held_centre - centre).norm(), 1e-12);
  for (const Vec3& spin : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.3, -1, 0.7)}) {
    double energy = 0.0;  // J, of that spin about the tool's position
    for (std::size_t k = 0; k < state.held.size(); ++k) {
      energy += 0.5 * model.mass[state.held[k]] * spin.cross(state.held_at[k]).squaredNorm();
    }
    EXPECT_NEAR(0.5 * spin.dot(force.held_inertia * spin), energy, 1e-12 * energy);
  }
}

using MovingTool = WithTools;
PHYMUL_ON_EVERY_BACKEND(MovingTool);

TEST_P(MovingTool, IsAtItsPoseAtTheEndOfTheCallAndGoesOnWithItsVelocity) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  scene.add_tool("probe", {.shape = Sphere{0.001}, .pose = {.position = {0.1, 0, 0}}});
  const auto solver = make(model, scene);
  const double dt = 0.3 * solver->stable_step();
  EXPECT_EQ(solver->tool_pose("probe").position, Vec3(0.1, 0, 0));
  const Quaternion quarter(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  const ToolPose to{.position = {0.2, 0.1, 0}, .orientation = quarter, .velocity = {0, 0, 3.0}, .spin = {0, 0, 2.0}};
  scene.tool("probe").move_to(to);
  ASSERT_TRUE(solver->step(10, dt).ok());
  EXPECT_EQ(solver->tool_pose("probe"), to);
  ASSERT_TRUE(solver->step(20, dt).ok());
  const ToolPose& gone_on = solver->tool_pose("probe");
  EXPECT_NEAR((gone_on.position - Vec3(0.2, 0.1, 60 * dt)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(Eigen::AngleAxisd(gone_on.orientation.toRotationMatrix()).angle(), M_PI / 2 + 40 * dt, 1e-9);
  scene.tool("probe").teleport({.position = {0.3, 0, 0}, .velocity = {0, 0, 3.0}});
  for (const int steps : {2, 3, 5}) ASSERT_TRUE(solver->step(steps, dt).ok());
  EXPECT_NEAR((solver->tool_pose("probe").position - Vec3(0.3, 0, 30 * dt)).norm(), 0.0, 1e-9);
}

TEST_P(MovingTool, PlacedOverParticlesLetsThemOutWithoutSpeed) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  scene.add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.5}}});
  const auto solver = make(model, scene);
  scene.tool("ball").teleport({.position = {0.01, 0.01, 0.0251}});
  const StepReport report = solver->step(1, 0.3 * solver->stable_step());
  ASSERT_TRUE(report.ok());
  EXPECT_LE(report.max_speed, 1e-9);
  EXPECT_LE(solver->tool_force("ball").force.norm(), 1e-6);
  int out = 0;
  const State state = solver->read();
  for (Index i = 0; i < model.particle_count(); ++i) {
    EXPECT_GE((state.position[i] - Vec3(0.01, 0.01, 0.0251)).norm(), 0.008 * (1 - 4 * roundoff()) - 2 * roundoff());
    out += state.position[i] != model.rest[i];
  }
  EXPECT_GE(out, 5);
}

TEST_P(MovingTool, HoldsWhatItGraspedAndFeelsItsInertia) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  scene.add_tool("jaw", {.shape = Box{{0.006, 0.006, 0.001}}, .pose = {.position = {0.01, 0.01, 0.0215}}});
  const auto solver = make(model, scene, {.damping = {.rate = 100.0}, .rest_tolerance = 1e-6});
  const double dt = 0.4 * solver->stable_step();
  scene.tool("jaw").grasp(0.0006);
  ASSERT_TRUE(solver->step(1, dt).ok());
  ASSERT_TRUE(solver->run_to_rest(40000, dt).converged());
  const double weight = total_mass(model) * 9.81;
  EXPECT_NEAR(solver->tool_force("jaw").force.z(), -weight, 1e-3 * weight);
  EXPECT_EQ(solver->tool_force("jaw").particles, 9);
  const State held = solver->read();
  ASSERT_EQ(held.tools.at(0).held.size(), 9u);
  expect_weighed(solver->tool_force("jaw"), held.tools[0], model);

  const ToolPose turned{.position = {0.05, 0.0, 0.03},
                        .orientation = Quaternion(Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized()))};
  scene.tool("jaw").move_to(turned);
  ASSERT_TRUE(solver->step(500, dt).ok());
  const State moved = solver->read();
  for (std::size_t k = 0; k < 9; ++k) {
    const Vec3 expected = turned.position + turned.orientation * moved.tools[0].held_at[k];
    EXPECT_LE((moved.position[moved.tools[0].held[k]] - expected).norm(), 1e-9 + 16 * roundoff() * 0.05);
  }
  expect_weighed(solver->tool_force("jaw"), held.tools[0], model);
  scene.tool("jaw").release();
  ASSERT_TRUE(solver->step(100, dt).ok());
  EXPECT_TRUE(solver->read().tools.at(0).held.empty());
  EXPECT_EQ(solver->tool_force("jaw").held_mass, 0.0);
  EXPECT_EQ(solver->tool_force("jaw").held_inertia.norm(), 0.0);
  EXPECT_LT((solver->momentum().linear / total_mass(model)).z(), -0.05);
  solver->reset(held);
  expect_weighed(solver->tool_force("jaw"), held.tools[0], model);
}

/// m d / T^2 over a call of T s, however far: who shows that to a hand limits it.
TEST_P(MovingTool, ThatHoldsFeelsAJumpAsItsLoadsInertia) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  scene.add_tool("jaw", {.shape = Sphere{0.02}, .pose = {.position = {0.01, 0.01, 0.01}}});  // all of it
  const auto solver = make(model, scene);
  const double dt = 0.3 * solver->stable_step(), seconds = 5 * dt;
  scene.tool("jaw").grasp(0.0);
  ASSERT_TRUE(solver->step(5, dt).ok());
  scene.tool("jaw").move_to({.position = {0.11, 0.01, 0.01}});
  ASSERT_TRUE(solver->step(5, dt).ok());
  const double inertia = total_mass(model) * 0.1 / (seconds * seconds);
  EXPECT_NEAR(solver->tool_force("jaw").mean_force.x(), -inertia, 1e-3 * inertia);
}

TEST_P(MovingTool, AFailureNamesAToolThatHolds) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  scene.add_tool("jaw", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.01}}});
  const auto solver = make(model, scene);
  const double dt = 0.3 * solver->stable_step();
  for (const bool grasps : {false, true}) {
    if (grasps) scene.tool("jaw").grasp(0.001);
    ASSERT_TRUE(solver->step(1, dt).ok());
    scene.tool("jaw").move_to({.position = {grasps ? 1e7 : 0.01, 0.01, 0.01}});
    if (!grasps) scene.gravity({0, 0, -1e16});
    const StepReport report = solver->step(10, dt);
    ASSERT_EQ(report.status, StepStatus::not_finite);
    EXPECT_EQ(bool(says(report.message(), "VirtualCoupling::follow")), grasps);
    scene.gravity({0, 0, 0});
  }
}

TEST_P(MovingTool, FixedParticlesAreNotMoved) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  scene.fix("z1").add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.03}}});
  const auto solver = make(model, scene);
  scene.tool("ball").move_to({.position = {0.01, 0.01, 0.024}});
  scene.tool("ball").grasp(0.01);
  ASSERT_TRUE(solver->step(20, 0.3 * solver->stable_step()).ok());
  const State state = solver->read();
  for (const Index i : model.group("z1")) EXPECT_LE((state.position[i] - model.rest[i]).norm(), 1e-9);
  // Nor counted: the ball reaches no others.
  EXPECT_EQ(solver->tool_force("ball").particles, 0);
  EXPECT_EQ(solver->tool_force("ball").force, Vec3(0, 0, 0));
}

/// A block flies past a ball, twice its own size away from where its rest shape is, and is taken back to before.
TEST_P(MovingTool, MeetsABodyFarFromItsRestShape) {
  const Model model = soft_block({0.04, 0.04, 0.04}, 8, 8, 8);
  Scene scene(model);
  scene.add_tool("ball", {.shape = Sphere{0.01}, .pose = {.position = {0.135, 0.02, 0.02}}});
  const auto solver = make(model, scene);
  State state = solver->read();
  for (Vec3& v : state.velocity) v = {4.0, 0.0, 0.0};
  solver->reset(state);
  const double dt = 0.5 * solver->stable_step();
  const auto until_met = [&] {
    int steps = 0;
    while (steps < 1000 && solver->tool_force("ball").particles == 0 && solver->step(1, dt).ok()) ++steps;
    return steps;
  };
  // Its face, 85 mm from the ball's near side.
  EXPECT_NEAR(until_met() * dt, 0.085 / 4.0, 0.5e-3 / 4.0 + dt);
  const State met = solver->read();
  solver->step(20, dt);
  const Vec3 force = solver->tool_force("ball").mean_force;
  EXPECT_GT(force.x(), 0.0);
  solver->reset(met);
  solver->step(20, dt);
  EXPECT_NEAR((solver->tool_force("ball").mean_force - force).norm(), 0.0, 1e-3 * force.norm());
}

/// SolverOptions::max_displacement_per_step, so small that it acts under tools at rest.
TEST_P(MovingTool, BearsTheForceThatTheLimitWithholds) {
  const Model model = soft_block({0.04, 0.04, 0.015}, 9, 9, 4);
  Scene scene = Scene(model).fix("z0");
  scene.add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.011, 0.019, 0.02}}});
  scene.add_tool("jaw", {.shape = Box{{0.004, 0.004, 0.001}}, .pose = {.position = {0.03, 0.02, 0.0165}}});
  SolverOptions options{.damping = {.rate = 600.0},
                        .max_displacement_per_step = std::numeric_limits<double>::infinity()};
  const auto unlimited = make(model, scene, options);
  const double dt = 0.4 * unlimited->stable_step();
  scene.tool("jaw").grasp(0.0006);
  ASSERT_TRUE(unlimited->step(1, dt).ok());
  scene.tool("jaw").move_to({.position = {0.031, 0.02, 0.019}});
  for (const int steps : {300, 1000}) ASSERT_TRUE(unlimited->step(steps, dt).ok());  // the way, and until it rests

  options.max_displacement_per_step = 1e-3;
  const auto limited = make(model, scene, options);
  limited->reset(unlimited->read());
  const StepReport report = limited->step(1, dt);
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE(report.force_clamped);
  for (const char* name : {"ball", "jaw"}) {
    const ToolForce &expected = unlimited->tool_force(name), &got = limited->tool_force(name);
    EXPECT_GT(expected.force.norm(), 0.1);
    EXPECT_LT((got.force - expected.force).norm(), 1e-4 * expected.force.norm()) << name;
    EXPECT_LT((got.torque - expected.torque).norm(), 1e-4 * expected.torque.norm() + 1e-6) << name;
  }
}

/// Also between a change of the scene and the step that sees it.
TEST_P(MovingTool, ReportsAreOfTheToolAskedFor) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  scene.add_tool("far", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}}});
  scene.add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.03}}});
  const auto solver = make(model, scene);
  const ToolHandle ball = scene.tool("ball"), far = scene.tool("far");
  ball.move_to({.position = {0.01, 0.01, 0.026}});
  ASSERT_TRUE(solver->step(50, 0.3 * solver->stable_step()).ok());
  const Vec3 pushed = solver->tool_force("ball").force;
  EXPECT_GT(pushed.norm(), 0.0);
  scene.remove_tool("far");
  EXPECT_EQ(solver->tool_force("ball").force, pushed);
  EXPECT_EQ(&solver->tool_force(ball), &solver->tool_force("ball"));
  EXPECT_EQ(&solver->tool_pose(ball), &solver->tool_pose("ball"));
  scene.add_tool("new", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 2}}});
  EXPECT_EQ(solver->tool_force("new").force, Vec3(0, 0, 0));
  EXPECT_EQ(solver->tool_pose("new").position, Vec3(0, 0, 2));
  EXPECT_TRUE(refuses([&] { solver->tool_force(far); }, "no longer has the tool of this handle"));
  Scene same = scene.copy();
  EXPECT_TRUE(refuses([&] { solver->tool_pose(same.tool("ball")); }, "of a tool of another scene"));
}

TEST_P(MovingTool, StatesThatDoNotFitAreRefused) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  scene.add_tool("jaw", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}}});
  const auto solver = make(model, scene);
  const auto message = [&](const ToolState& tool) {
    State state = rest_state(model);
    state.tools.push_back(tool);
    return message_of([&] { solver->reset(state); });
  };
  EXPECT_TRUE(says(message({.name = "jaw", .held = {27}, .held_at = {Vec3::Zero()}}), "tool \"jaw\" has particles"));
  EXPECT_TRUE(says(message({.name = "jaw", .held = {2}}), "unlike lengths"));
  EXPECT_TRUE(says(message({.name = "jaw", .needle = {.hole = {{.particles = {0}}}}}), "unlike lengths"));
  EXPECT_EQ(message({.name = "jaw", .held = {2}, .held_at = {Vec3::Zero()}}), "(no error)");
}

TEST_P(MovingTool, PosingEveryMillisecondAllocatesNothing) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene = Scene(model).fix("z0").gravity({0, 0, -1.0});
  const bool takes_surface = GetParam() == "reference" || GetParam() == "cpu";
  scene.add_tool("ball", {.shape = Sphere{0.008},
                          .pose = {.position = {0.01, 0.01, 0.028}},
                          .friction = 0.3,
                          .contact = takes_surface ? ToolContact::surface : ToolContact::particles});
  const auto solver = make(model, scene);
  const double dt = 0.4 * solver->stable_step();
  const ToolHandle ball = scene.tool("ball");
  // As many as below: a driver compiles anew for steps that do not measure, and allocates then.
  ASSERT_TRUE(solver->step(3, dt).ok());
  const std::size_t before = allocation_count();
  int touched = 0;
  for (int k = 0; k < 50; ++k) {
    ball.move_to({.position = {0.01, 0.01, 0.028 - 1e-4 * k}});
    if (!solver->step(3, dt).ok()) break;
    touched += solver->tool_force("ball").particles;
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(touched, 50);
}

TEST(ToolOfTheFastBackend, GivesTheSameBitsForAnyNumberOfThreads) {
  const Model model = soft_block({0.03, 0.03, 0.03}, 15, 15, 15);  // 4,096 particles: several clusters
  const auto run = [&](int threads, ToolContact contact) {
    Scene scene = Scene(model).fix("z0");
    scene.add_tool("ball", {.shape = Sphere{0.01},
                            .pose = {.position = {0.015, 0.016, 0.041}, .velocity = {0.1, 0, -0.5}},
                            .friction = 0.4,
                            .contact = contact});
    const SolverOptions options{.spectrum = Spectrum{.largest = 1e8}, .threads = threads};
    const auto solver = make_solver("cpu", model, scene, {}, options);
    EXPECT_TRUE(solver->step(60, 5e-5).ok());
    EXPECT_GT(solver->tool_force("ball").particles, 5);
    return std::pair(solver->read(), solver->tool_force("ball").force);
  };
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    const auto one = run(1, contact), three = run(3, contact);
    EXPECT_EQ(one.first, three.first);
    EXPECT_EQ(one.second, three.second);
  }
}

TEST(ToolOfOtherBackends, NeedlesAreTakenByAll) {
  const Model model = make_tetrahedron(0.01);
  for (const std::string& name : backend_names()) {
    Scene scene(model);
    if (!why_unavailable(name).empty()) continue;
    const auto solver = make_solver(name, model, scene);
    EXPECT_TRUE(solver->takes_tools()) << name;
    scene.add_tool("needle", {.shape = Needle{}, .pose = {.position = {0, 0, 1}}});
    EXPECT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok()) << name;
    EXPECT_NO_THROW(make_solver(name, model, scene)) << name;
  }
}

TEST(ToolOfOtherBackends, SurfacesAreTouchedOnAll) {
  const Model model = make_tetrahedron(0.01);
  for (const std::string& name : backend_names()) {
    Scene scene(model);
    if (!why_unavailable(name).empty()) continue;
    const auto solver = make_solver(name, model, scene);
    scene.add_tool("ball", {.shape = Sphere{0.001}, .pose = {.position = {0, 0, 1}}, .contact = ToolContact::surface});
    EXPECT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok()) << name;
    EXPECT_NO_THROW(make_solver(name, model, scene)) << name;
  }
}

}  // namespace
}  // namespace phymul::test
