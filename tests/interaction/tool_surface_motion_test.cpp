// SPDX-License-Identifier: MIT
//
// Tools with ToolContact::surface: rest, hard hits, fast tools, and what another tool holds.
#include <array>
#include <cmath>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

class ToolSurfaceMotionOn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(ToolSurfaceMotionOn);

/// Tools with and without edges, some of whose points stay inside for a while.
TEST_P(ToolSurfaceMotionOn, WhatIsPressedComesToRest) {
  const Model model = soft_block({0.04, 0.04, 0.02}, 6, 6, 3);
  const std::array<ToolShape, 3> shapes{Sphere{0.01}, Capsule{0.004, 0.05}, Box{{0.011, 0.003, 0.01}}};
  for (const ToolShape& shape : shapes) {
    Scene scene(model);
    scene.fix("z0").add_tool("tool", {.shape = shape, .contact = ToolContact::surface});
    scene.tool("tool").teleport({.position = {0.0212, 0.0201, 0.03}});
    SolverOptions options = damped(150.0);
    options.rest_tolerance = 3e-7;  // rounding keeps single precision moving
    const auto solver = make(model, scene, options);
    const double deep = std::holds_alternative<Capsule>(shape) ? 0.0224 : 0.0284;
    scene.tool("tool").move_to({.position = {0.0212, 0.0201, deep}});
    ASSERT_TRUE(solver->step(100, 0.5 * solver->stable_step()).ok());
    const RestResult rest = solver->run_to_rest(4000, 0.5 * solver->stable_step());
    EXPECT_TRUE(rest.converged()) << shape.index() << ": " << rest.message();
    EXPECT_GT(solver->tool_force("tool").force.z(), 0.05);
  }
}

/// Its inside must not pass through the tool where its surface was stopped.
TEST_P(ToolSurfaceMotionOn, ABallFlungAtAPlateGainsNoEnergy) {
  const Model model = with_material(make_body(solid_ball({0, 0, 0}, 0.02), {.spacing = 0.006}));
  for (const bool is_box : {false, true}) {
    Scene scene(model);
    Tool plate{.shape = HalfSpace{}, .contact = ToolContact::surface};
    if (is_box) plate.shape = Box{{0.1, 0.1, 0.02}};
    plate.pose.position = {0, 0, is_box ? -0.042 : -0.022};
    scene.add_tool("plate", plate);
    const auto solver = make(model, scene);
    State flung = rest_state(model);
    for (Vec3& v : flung.velocity) v = {0, 0, -50};
    solver->reset(flung);
    const double before = solver->energy().total(), dt = 0.5 * solver->stable_step();
    double most = 0.0;
    for (int k = 0; k < 40; ++k) {
      ASSERT_TRUE(solver->step(1, dt).ok());
      most = std::max(most, solver->energy().total());
    }
    EXPECT_LE(most, before * (1.0 + 1e-3)) << is_box;
    EXPECT_LT(solver->energy().total(), 0.9 * before) << "it has met the plate";
  }
}

/// What one tool holds another does not move, and does not feel.
TEST_P(ToolSurfaceMotionOn, WhatAnotherToolHoldsStays) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene = Scene(model).fix("z0");
  scene.add_tool("jaw", {.shape = Box{{0.02, 0.02, 0.002}}, .pose = {.position = {0.01, 0.01, 0.022}}});
  scene.tool("jaw").grasp(1e-4);
  scene.add_tool("ball",
                 {.shape = Sphere{0.006}, .pose = {.position = {0.01, 0.01, 0.0265}}, .contact = ToolContact::surface});
  const auto solver = make(model, scene);
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(1, dt).ok());
  ASSERT_EQ(solver->held("jaw"), 25);
  scene.tool("ball").move_to({.position = {0.01, 0.01, 0.0225}});
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(solver->step(2, dt).ok());
    EXPECT_EQ(solver->tool_force("ball").force, Vec3(0, 0, 0));
  }
  for (const Index i : model.group("z1")) {
    EXPECT_LE((solver->read().position[i] - model.rest[i]).norm(), 1e-6 * 0.02);
  }
}

/// Beyond what it passes in a step: a rod that is thin beside its way.
TEST_P(ToolSurfaceMotionOn, AFastRodIsFeltWhereItPassesTheSurface) {
  const Model model = soft_block({0.04, 0.04, 0.04}, 8, 8, 8);
  Scene scene = Scene(model).fix("z0");
  const Quaternion lying(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()));
  scene.add_tool("rod", {.shape = Capsule{0.001, 0.05},
                         .pose = {.position = {-0.005, 0.0212, 0.05}, .orientation = lying},
                         .contact = ToolContact::surface});
  const auto solver = make(model, scene);
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(1, dt).ok());
  scene.tool("rod").move_to({.position = {-0.005, 0.0212, 0.03}, .orientation = lying});
  ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_GT(solver->tool_force("rod").force.z(), 1.0);
  // It pushes down what it met: nothing of the surface is above it.
  for (const Index i : model.group("z1")) {
    const Vec3& rest = model.rest[i];
    if (std::abs(rest.y() - 0.02) < 0.001 && rest.x() > 0.001 && rest.x() < 0.039) {
      EXPECT_LT(solver->read().position[i].z(), 0.0395);
    }
  }
}

/// It goes past the surface by three times its thickness. It covers one corner of each triangle.
TEST_P(ToolSurfaceMotionOn, AThinPlateKeepsTheSideThatItComesFrom) {
  const Model model = soft_block({0.04, 0.04, 0.04}, 8, 8, 8);
  for (const double side : {1.0, -1.0}) {  // of the plate that is its lower one
    Scene scene = Scene(model).fix("z0");
    const Quaternion turn(Eigen::AngleAxisd(side > 0.0 ? M_PI : 0.0, Vec3::UnitX()));
    scene.add_tool("plate", {.shape = Box{{0.03, 0.004, 2e-4}},
                             .pose = {.position = {0.02, 0.0201, 0.0404}, .orientation = turn},
                             .contact = ToolContact::surface});
    const auto solver = make(model, scene);
    const double dt = 0.3 * solver->stable_step();
    ASSERT_TRUE(solver->step(1, dt).ok());
    ASSERT_EQ(solver->tool_force("plate").force, Vec3(0, 0, 0));
    scene.tool("plate").move_to({.position = {0.02, 0.0201, 0.0390}, .orientation = turn});
    ASSERT_TRUE(solver->step(1, dt).ok());
    EXPECT_GT(solver->tool_force("plate").force.z(), 1.0) << side;
    for (const Index i : model.group("z1")) {
      if (std::abs(model.rest[i].y() - 0.02) < 0.001) {
        EXPECT_LT(solver->read().position[i].z(), 0.0395) << side;
      }
    }
  }
}

/// Triangles over the box's edges are pushed as they lie, not along the edge: 0.09 m/s if points are looked for once.
TEST(ToolSurface, ABoxWithoutFrictionLetsTissueComeToRestAboutItsEdges) {
  Model lobe = make_body(solid_ellipsoid({0, 0, 0}, {0.018, 0.018, 0.012}), {.spacing = 4e-3});
  set_material(lobe, {.young = 5e3, .poisson = 0.45, .density = 1000.0});
  lobe.add_group("held", lobe.particles_in([](const Vec3& x) { return x.z() < -0.006; }));
  Scene scene(lobe);
  const Box box{{0.005, 0.005, 0.005}};
  const auto pressed = [](double by) { return ToolPose{.position = {0, 0, 0.017 - by}}; };
  scene.fix("held").add_tool("box", {.shape = box, .pose = pressed(0.0), .contact = ToolContact::surface});
  const auto solver = make_solver("cpu", lobe, scene, {}, damped(150.0));
  const int steps = static_cast<int>(std::ceil(1e-3 / (0.45 * solver->stable_step())));
  for (int tick = 1; tick <= 250; ++tick) {
    scene.tool("box").move_to(pressed(3.5e-5 * std::min(tick, 100)));
    ASSERT_TRUE(is_ok(solver->step(steps, 1e-3 / steps)));
  }
  double fastest = 0.0;
  for (const Vec3& velocity : solver->read().velocity) fastest = std::max(fastest, velocity.norm());
  EXPECT_LT(fastest, 5e-3);
  EXPECT_GT(solver->tool_force("box").mean_force.norm(), 0.3);
}

/// A triangle through a box is pushed to both sides at once: it goes no farther than it is deep.
TEST(ToolSurface, AThinBoxPutOverABodyLetsItOutWhereItIs) {
  Model lobe = make_body(solid_ellipsoid({0, 0, 0}, {0.025, 0.03, 0.015}), {.spacing = 4e-3});
  set_material(lobe, {.young = 5e3, .poisson = 0.4, .density = 1000.0});
  lobe.add_group("held", lobe.particles_in([](const Vec3& x) { return x.z() < -0.009; }));
  for (const auto& [half, down] : {std::pair{2e-3, 3e-3}, std::pair{1e-3, 1e-3}, std::pair{3e-4, 5e-4}}) {
    Scene scene(lobe);
    scene.fix("held").add_tool("box", {.shape = Box{{half, 0.01, 0.01}},
                                       .pose = {.position = {0, 0, 0.025 - down}},
                                       .contact = ToolContact::surface});
    const auto solver = make_solver("cpu", lobe, scene, {}, damped(100.0));
    ASSERT_TRUE(is_ok(solver->step(1, 0.8 * solver->stable_step())));
    EXPECT_LT(largest_distance(solver->read().position, lobe.rest), 2.0 * (down + 4e-3)) << half;
  }
}

/// Steps of other lengths than those before move out what is inside as if the tool had been put over it.
TEST(ToolSurface, StepsOfAnyLengthInTurnsThrowNothingOutOfABox) {
  const Model block = soft_block({0.02, 0.02, 0.02}, 3, 3, 3);
  for (const double turn : {0.0, 0.3}) {
    Scene scene(block);
    ToolPose pose{.position = {0.0103, 0.0098, 0.0235},
                  .orientation = Quaternion(Eigen::AngleAxisd(turn, Vec3(1, 0.3, 0.2).normalized()))};
    const ToolHandle box = scene.fix("z0").add_tool(
        "box", {.shape = Box{{0.006, 0.006, 0.002}}, .pose = pose, .contact = ToolContact::surface});
    const auto solver = make_solver("reference", block, scene, {}, damped(150.0));
    const double dt = 0.4 * solver->stable_step();
    for (int k = 0; k < 22; ++k) {
      pose.position.z() -= 1e-4;
      box.move_to(pose);
      ASSERT_TRUE(is_ok(solver->step(20, dt)));
    }
    for (int k = 0; k < 10; ++k) {
      for (const double share : {1.0, 0.5, 1e-2, 1e-6}) {
        const StepReport report = solver->step(1, share * dt);
        ASSERT_TRUE(is_ok(report));
        EXPECT_LT(report.max_speed, 0.3) << turn << ' ' << k << ' ' << share;
      }
    }
  }
}

/// As far as particles enter by their own force, whatever the rounds and the length of a step.
TEST(ToolSurface, EntersByItsCompliance) {
  const Model block = soft_block({0.04, 0.04, 0.02}, 4, 4, 2);
  for (const double share : {0.2, 0.8}) {
    Scene scene(block);
    constexpr double compliance = 5e-3, plane = 0.019;
    scene.fix("z0").add_tool("plate", {.shape = Box{{0.05, 0.05, 0.01}},
                                       .pose = {.position = {0.02, 0.02, plane + 0.01}},
                                       .compliance = compliance,
                                       .contact = ToolContact::surface});
    const auto solver = make_solver("cpu", block, scene, {}, damped(150.0));
    const double dt = share * solver->stable_step();
    ASSERT_TRUE(is_ok(solver->step(static_cast<int>(0.3 / dt), dt)));
    double entered = 0.0;
    for (const Index i : block.group("z1")) entered += solver->read().position[i].z() - plane;
    const double force = solver->tool_force("plate").mean_force.z();
    EXPECT_GT(entered, 1e-3);
    EXPECT_NEAR(entered, compliance * force, 0.01 * entered) << share;
  }
}

}  // namespace
}  // namespace phymul::test
