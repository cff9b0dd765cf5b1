// SPDX-License-Identifier: MIT
//
// Tools with ToolContact::surface: what they feel does not depend on where particles are.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double cell = 5e-3;  // m
constexpr int cells_across = 10, cells_high = 6;
// Of the upper face: a particle.
const Vec3 top_middle(0.5 * cells_across * cell, 0.5 * cells_across * cell, cells_high* cell);

Model slab() {
  Model model =
      make_block({cells_across * cell, cells_across * cell, cells_high * cell}, cells_across, cells_across, cells_high);
  set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000});
  return model;
}

class ToolSurfaceOn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(ToolSurfaceOn);

/// A tool that a hand moves by ticks of 1 ms.
class PressedSlab {
 public:
  PressedSlab(const Model& model, const Tool& tool, const std::string& backend = "cpu") : scene_(model) {
    scene_.fix("z0").add_tool("tool", tool);
    solver_ = make_solver(backend, model, scene_, {}, damped(100.0));
    steps_ = static_cast<int>(std::ceil(1e-3 / (0.5 * solver_->stable_step())));
  }

  const ToolForce& tick(const Vec3& position) {
    scene_.tool("tool").move_to({.position = position});
    EXPECT_TRUE(is_ok(solver_->step(steps_, 1e-3 / steps_)));
    return solver_->tool_force("tool");
  }
  /// Comes down on a place in 1 mm per 10 ticks, and rests there.
  const ToolForce& press(const Vec3& from, double depth) {
    const int ticks = static_cast<int>(std::ceil(1e4 * depth));
    for (int k = 1; k <= ticks; ++k) tick(from - Vec3(0, 0, depth * k / ticks));
    for (int k = 0; k < 100; ++k) tick(from - Vec3(0, 0, depth));
    return solver_->tool_force("tool");
  }

 private:
  Scene scene_;
  std::unique_ptr<Solver> solver_;
  int steps_ = 0;
};

Tool ball_of(double radius, ToolContact contact, double friction = 0.1) {
  return {.shape = Sphere{radius},
          .pose = {.position = top_middle + Vec3(0, 0, radius + 1e-3)},
          .friction = friction,
          .contact = contact};
}

/// Over a particle, an edge, a diagonal of a cell and in a triangle.
const std::array<Vec3, 4> four_places{Vec3(0, 0, 0), Vec3(0.5, 0, 0), Vec3(0.5, 0.5, 0), Vec3(0.7, 0.2, 0)};

/// Least and largest force over the places.
std::pair<double, double> range_of_forces(double radius, double depth, ToolContact contact) {
  const Model model = slab();
  double least = INFINITY, most = 0.0;
  for (const Vec3& place : four_places) {
    PressedSlab pressed(model, ball_of(radius, contact));
    const double force = pressed.press(top_middle + cell * place + Vec3(0, 0, radius), depth).mean_force.z();
    least = std::min(least, force);
    most = std::max(most, force);
  }
  return {least, most};
}

/// Contact radius: 1.2 cells. With the correction for a layer of finite depth that contact_test.cpp cites.
TEST(ToolSurface, ForceOfABallIsThatOfHertzAtEveryPlace) {
  const double radius = 0.012, depth = 3e-3, nu = 0.3;
  const auto [least, most] = range_of_forces(radius, depth, ToolContact::surface);
  const double hertz = 4.0 / 3.0 * 10e3 / (1.0 - nu * nu) * std::sqrt(radius) * std::pow(depth, 1.5);
  const double alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
  const double chi = std::sqrt(radius * depth) / (cells_high * cell);
  const double layer = 1.0 - 2.0 * alpha / M_PI * chi + std::pow(2.0 * alpha / M_PI * chi, 2);
  RecordProperty("least", std::to_string(least / (hertz * layer)));
  RecordProperty("most", std::to_string(most / (hertz * layer)));
  EXPECT_GT(least, 0.8 * hertz * layer);
  EXPECT_LT(most, 1.2 * hertz * layer);
  EXPECT_LT(most, 1.06 * least);
}

/// As wide as a cell, pressed in by its radius.
TEST(ToolSurface, ForceOfASmallBallDependsLessOnThePlaceThanAtParticles) {
  const auto at_particles = range_of_forces(cell, cell, ToolContact::particles);
  const auto at_surface = range_of_forces(cell, cell, ToolContact::surface);
  RecordProperty("particles", std::to_string(at_particles.second / at_particles.first));
  RecordProperty("surface", std::to_string(at_surface.second / at_surface.first));
  EXPECT_LT(at_surface.second, 1.15 * at_surface.first);
  EXPECT_GT(at_particles.second, 1.3 * at_particles.first);
}

/// A rod of a fifth of a cell, in the middle of a triangle.
TEST(ToolSurface, AThinRodBetweenParticlesIsFelt) {
  const Model model = slab();
  const double radius = 0.2 * cell;
  const Vec3 from = top_middle + cell * Vec3(0.7, 0.3, 0) + Vec3(0, 0, radius);
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    PressedSlab pressed(model, {.shape = Capsule{radius, 0.1}, .pose = {.position = from}, .contact = contact});
    int felt = 0;
    for (int k = 1; k <= 40; ++k) felt += pressed.tick(from - Vec3(0, 0, 1e-4 * k)).mean_force.z() > 0.0 ? 1 : 0;
    EXPECT_EQ(felt, contact == ToolContact::surface ? 40 : 0);
  }
}

/// Largest change of the force in a tick, of itself, of a ball that slides over two cells at 5 cm/s.
double largest_jump(ToolContact contact, const std::string& backend) {
  const Model model = slab();
  const double radius = 0.8 * cell, depth = 0.6 * cell;
  PressedSlab pressed(model, ball_of(radius, contact), backend);
  const Vec3 from = top_middle - cell * Vec3(1, 0.2, 0) + Vec3(0, 0, radius);
  double before = pressed.press(from, depth).mean_force.norm(), jump = 0.0;
  for (int k = 1; k <= 200; ++k) {
    const double now = pressed.tick(from + Vec3(5e-5 * k, 1e-5 * k, -depth)).mean_force.norm();
    if (k > 20) jump = std::max(jump, std::abs(now - before) / before);  // it first has to begin to slide
    before = now;
  }
  return jump;
}

TEST_P(ToolSurfaceOn, ForceIsContinuousAsABallSlidesOverTriangles) {
  const double at_particles = largest_jump(ToolContact::particles, GetParam()),
               at_surface = largest_jump(ToolContact::surface, GetParam());
  RecordProperty("particles", std::to_string(at_particles));
  RecordProperty("surface", std::to_string(at_surface));
  EXPECT_LT(at_surface, 0.02);
  EXPECT_GT(at_particles, 0.04);
}

/// A plate over the whole face, all of whose normals are one: the sum is in the cone that each point's force is in.
TEST_P(ToolSurfaceOn, FrictionStaysInCoulombsConeAndReachesIt) {
  const Model model = slab();
  const double half = 0.01;
  const Vec3 from = top_middle + Vec3(0, 0, half);
  PressedSlab pressed(model,
                      {.shape = Box{{cells_across * cell, cells_across * cell, half}},
                       .pose = {.position = from},
                       .friction = 0.3,
                       .contact = ToolContact::surface},
                      GetParam());
  pressed.press(from, 1e-3);
  const bool on_device = GetParam().starts_with("gl");  // processors add up forces in double
  const double cone = on_device ? 1e3 * roundoff() : 1e-9;
  double share = 0.0;
  for (int k = 1; k <= 100; ++k) {
    const Vec3 force = pressed.tick(from + Vec3(1e-4 * k, 0, -1e-3)).force;
    share = -force.x() / force.z();
    ASSERT_LT(std::hypot(force.x(), force.y()), 0.3 * force.z() * (1.0 + cone)) << k;
    ASSERT_GT(share, 0.0) << k;
  }
  EXPECT_NEAR(share, 0.3, 0.01);
}

/// Under a face particles are the points that act.
TEST(ToolSurface, AFaceThatCoversTheSurfaceFeelsWhatItFeelsAtParticles) {
  const Model model = slab();
  const Vec3 from = top_middle + Vec3(0, 0, 0.01);
  double force[2];
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    PressedSlab pressed(model, {.shape = Box{{0.04, 0.04, 0.01}}, .pose = {.position = from}, .contact = contact});
    force[static_cast<std::size_t>(contact)] = pressed.press(from, 1e-3).mean_force.z();
  }
  EXPECT_NEAR(force[1], force[0], 2e-6 * force[0]);
}

/// The slab turned by half a turn is the same slab, but its triangles begin at other corners.
TEST(ToolSurface, EdgesOfABoxOverTrianglesAreFeltWhicheverCornerIsFirst) {
  const Model model = slab();
  double force[2];
  for (const int turned : {0, 1}) {
    const Vec3 from = top_middle + (turned ? -1.0 : 1.0) * cell * Vec3(0.3, 0.2, 0) + Vec3(0, 0, 0.01);
    PressedSlab pressed(
        model, {.shape = Box{{0.01, 0.01, 0.01}}, .pose = {.position = from}, .contact = ToolContact::surface});
    force[turned] = pressed.press(from, 1e-3).mean_force.z();
  }
  EXPECT_GT(force[0], 0.0);
  EXPECT_NEAR(force[1], force[0], 2e-5 * force[0]);
}

/// Without friction the edges in front and behind press alike.
TEST(ToolSurface, AFrictionlessBoxIsHardlyHeldBackAsItSlides) {
  const Model model = slab();
  const Vec3 from = top_middle + Vec3(-0.3 * cell, 0.2 * cell, 0.002);
  PressedSlab pressed(
      model, {.shape = Box{{0.01, 0.012, 0.002}}, .pose = {.position = from}, .contact = ToolContact::surface});
  pressed.press(from, 1.5e-3);
  double held = 0.0, normal = 0.0;
  for (int k = 1; k <= 250; ++k) {  // a cell's length
    const Vec3 force = pressed.tick(from + Vec3(2e-5 * k, 0, -1.5e-3)).mean_force;
    held -= force.x();
    normal += force.z();
  }
  RecordProperty("drag_over_normal", std::to_string(held / normal));
  EXPECT_GT(normal, 0.0);
  EXPECT_LT(std::abs(held), 0.02 * normal);
}

/// One solver keeps the triangles that are near, the other looks for them anew before every call.
TEST(ToolSurface, KeptAndFreshTrianglesHaveTheSameBits) {
  const Model model = slab();
  Scene kept_scene(model), fresh_scene(model);
  for (Scene* scene : {&kept_scene, &fresh_scene}) {
    scene->fix("z0").add_tool("ball", ball_of(cell, ToolContact::surface));
    scene->add_tool("blade", {.shape = Box{{0.012, 0.001, 0.01}},
                              .pose = {.position = top_middle + Vec3(0.01, 0.01, 0.013)},
                              .contact = ToolContact::surface});
  }
  const auto kept = make_solver("cpu", model, kept_scene, {}, damped(100.0)),
             fresh = make_solver("cpu", model, fresh_scene, {}, damped(100.0));
  const double dt = 0.5 * kept->stable_step();
  for (int k = 1; k <= 200; ++k) {
    fresh->restore(fresh->snapshot());
    for (Scene* scene : {&kept_scene, &fresh_scene}) {
      const double deep = k <= 100 ? 5e-5 * k : 5e-3 - 1e-4 * (k - 100);
      scene->tool("ball").move_to({.position = top_middle + Vec3(-1e-4 * k, 0, cell + 1e-3 - deep)});
      scene->tool("blade").move_to({.position = top_middle + Vec3(0.01, 0.01, 0.013 - deep),
                                    .orientation = Quaternion(Eigen::AngleAxisd(0.01 * k, Vec3::UnitZ()))});
    }
    ASSERT_TRUE(is_ok(kept->step(2, dt)));
    ASSERT_TRUE(is_ok(fresh->step(2, dt)));
    ASSERT_EQ(kept->read(), fresh->read()) << k;
    if (k == 100) {
      EXPECT_GT(largest_distance(kept->read().position, model.rest), 1e-3);  // they do touch
    }
  }
}

TEST(ToolSurface, NeedlesAreRefusedAndAutoTakesTheProcessor) {
  const Model model = slab();
  Scene scene(model);
  EXPECT_TRUE(
      refuses([&] { scene.add_tool("n", {.shape = Needle{}, .contact = ToolContact::surface}); },
              "tool \"n\": expected ToolContact::particles, got surface: a needle finds the surface by itself"));
  scene.add_tool("ball", ball_of(cell, ToolContact::surface));
  EXPECT_EQ(make_solver("auto", model, scene)->name(), "cpu");
}

TEST_P(ToolSurfaceOn, TakesFromTheBodyWhatTheToolFeels) {
  const Model model = soft_block({0.03, 0.02, 0.02}, 6, 4, 4);
  Scene scene(model);
  ToolPose pose{.position = {0.012, 0.011, 0.029}, .velocity = {0.3, -0.2, -1.0}, .spin = {5, -3, 20}};
  scene.add_tool(
      "ball",
      {.shape = Sphere{0.01}, .pose = pose, .friction = 0.4, .compliance = 1e-3, .contact = ToolContact::surface});
  pose.position = {0.015, 0.01, -0.008};
  pose.velocity = {0, 0.1, 0.8};
  scene.add_tool("block",
                 {.shape = Box{{0.008, 0.006, 0.006}}, .pose = pose, .friction = 0.7, .contact = ToolContact::surface});
  const auto solver = make(model, scene, uncut());  // a cut force has no counterpart
  const double dt = 0.3 * solver->stable_step();
  double largest = 0.0;
  for (int k = 0; k < 60; ++k) largest = std::max(largest, balanced_step(*solver, {"ball", "block"}, dt));
  EXPECT_GT(largest, 0.1);  // N: they did meet
}

TEST_P(ToolSurfaceOn, PlacedOverASurfaceLetsItOutWithoutSpeed) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  const Vec3 over(0.0115, 0.0108, 0.0251);
  const double radius = 0.008;
  Scene scene(model);
  scene.add_tool("ball",
                 {.shape = Sphere{radius}, .pose = {.position = {0.01, 0.01, 0.5}}, .contact = ToolContact::surface});
  const auto solver = make(model, scene);
  scene.tool("ball").teleport({.position = over});
  const StepReport report = solver->step(1, 0.3 * solver->stable_step());
  ASSERT_TRUE(report.ok());
  EXPECT_LE(report.max_speed, 1e-9);
  EXPECT_LE(solver->tool_force("ball").force.norm(), 1e-6);
  const State state = solver->read();
  double deepest = 0.0, moved_by = 0.0;  // m
  for (const auto& [a, b, c] : surface_triangles(model)) {
    const Vec3 centre = (state.position[a] + state.position[b] + state.position[c]) / 3.0;
    deepest = std::max(deepest, radius - (centre - over).norm());
  }
  moved_by = std::max(moved_by, largest_distance(state.position, model.rest));
  EXPECT_GT(moved_by, 1e-3);
  EXPECT_LT(deepest, 0.01 * moved_by);  // was moved_by
}

/// What the rounds of a long step leave inside would come out of a short one with a blow.
TEST_P(ToolSurfaceOn, FeelsNoBlowWhenTheStepGetsShorter) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 6, 6, 6);
  Scene scene(model);
  const double radius = 0.008;
  scene.fix("z0").add_tool("ball", {.shape = Sphere{radius},
                                    .pose = {.position = {0.0112, 0.0093, 0.02 + radius}},
                                    .contact = ToolContact::surface});
  const auto solver = make(model, scene, damped(200.0));
  const double dt = 0.5 * solver->stable_step();
  scene.tool("ball").move_to({.position = {0.0112, 0.0093, 0.017 + radius}});
  for (const int steps : {300, 1000}) ASSERT_TRUE(solver->step(steps, dt).ok());
  const Snapshot rest = solver->snapshot();
  const double force = solver->tool_force("ball").force.norm();
  EXPECT_GT(force, 0.05);
  for (const double shorter : {0.5, 0.1, 0.01}) {
    solver->restore(rest);
    double largest = 0.0, sum = 0.0;
    const int steps = static_cast<int>(10.0 / shorter);
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(solver->step(1, shorter * dt).ok());
      largest = std::max(largest, solver->tool_force("ball").force.norm());
      sum += solver->tool_force("ball").force.z() / steps;
    }
    EXPECT_LT(largest, (shorter < 0.1 ? 5.0 : 1.4) * force) << shorter;
    EXPECT_NEAR(sum, force, 0.02 * force) << shorter;
  }
}

/// Bodies without triangles, and those that loads impose: as with ToolContact::particles.
TEST_P(ToolSurfaceOn, TouchesParticlesWhereThereAreNoTriangles) {
  const Model model = make_strip(0.04, 0.02, 8, 4);
  std::array<State, 2> end;
  std::array<Vec3, 2> force;
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    Scene scene = Scene(model).fix("y0");
    scene.add_tool(
        "ball",
        {.shape = Sphere{0.008}, .pose = {.position = {0.021, 0.0264, 0}}, .friction = 0.2, .contact = contact});
    const auto solver = make(model, scene);
    for (int k = 1; k <= 20; ++k) {
      scene.tool("ball").move_to({.position = {0.021, 0.0264 - 1e-4 * k, 0}});
      ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
    }
    const auto run = static_cast<std::size_t>(contact);
    end[run] = solver->read();
    force[run] = solver->tool_force("ball").force;
  }
  EXPECT_GT(force[0].norm(), 1e-6);
  EXPECT_LE((force[1] - force[0]).norm(), 1e4 * roundoff() * force[0].norm());
  EXPECT_LE(largest_distance(end[1].position, end[0].position), 1e3 * roundoff() * 0.04);
}

/// The tool does not move what loads impose, and does not feel it.
TEST_P(ToolSurfaceOn, WhatIsImposedStays) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene = Scene(model).fix("z1").fix("z0");
  scene.add_tool("ball", {.shape = Sphere{0.004},
                          .pose = {.position = {0.01, 0.01, 0.0245}},
                          .friction = 0.5,
                          .contact = ToolContact::surface});
  const auto solver = make(model, scene);
  for (int k = 1; k <= 10; ++k) {
    scene.tool("ball").move_to({.position = {0.01, 0.01, 0.0245 - 2e-4 * k}});
    ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
    EXPECT_EQ(solver->tool_force("ball").force, Vec3(0, 0, 0));
    EXPECT_EQ(solver->tool_force("ball").particles, 0);
  }
}

}  // namespace
}  // namespace phymul::test
