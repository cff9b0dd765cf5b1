// SPDX-License-Identifier: MIT
//
// Bodies against tools: closed forms of friction and indentation, balance of momentum, and what must not pass through.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "support/run_scenes.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double free_fall = 9.81;  // m/s^2

using Contact = WithTools;
PHYMUL_ON_EVERY_BACKEND(Contact);

/// A block on a half-space, gravity leaning by an angle.
struct Slope {
  Model model = soft_block({0.04, 0.04, 0.02}, 4, 4, 2);
  Scene scene{model};
  double angle;
  explicit Slope(double degrees, double friction) : angle(degrees * M_PI / 180.0) {
    scene.gravity({free_fall * std::sin(angle), 0, -free_fall * std::cos(angle)});
    scene.add_tool("floor", {.shape = HalfSpace{}, .friction = friction});
  }
};

TEST_P(Contact, BlockLiesStillBelowTheFrictionAngle) {
  for (const double degrees : {0.0, 20.0, 26.0}) {  // atan(0.5) = 26.57
    SCOPED_TRACE(degrees);
    Slope slope(degrees, 0.5);
    const auto solver = make(slope.model, slope.scene, damped(200.0));
    const double dt = 0.25 * solver->stable_step(), weight = total_mass(slope.model) * free_fall;
    const RestResult rest = solver->run_to_rest(20000, dt);
    ASSERT_TRUE(rest.converged()) << rest.message();
    const Vec3 force = solver->tool_force("floor").force;
    const Vec3 expected = weight * Vec3(std::sin(slope.angle), 0, -std::cos(slope.angle));
    EXPECT_LE((force - expected).norm(), 1e-4 * weight) << force.transpose();
    EXPECT_LE(rest.report.residual, 1e-4 * weight);
    // It stays there: no creep.
    const State before = solver->read();
    ASSERT_TRUE(solver->step(2000, dt).ok());
    EXPECT_LE(largest_distance(solver->read().position, before.position), 1e-5 * mean_spacing(slope.model));
  }
}

TEST_P(Contact, BlockSlidesBeyondTheFrictionAngleAsACoulombBlockDoes) {
  for (const double degrees : {27.0, 35.0}) {
    SCOPED_TRACE(degrees);
    Slope slope(degrees, 0.5);
    const double expected = free_fall * (std::sin(slope.angle) - 0.5 * std::cos(slope.angle));
    const SolverOptions options{.damping = {.rate = 200.0}};  // settles, at a terminal speed
    const auto settling = make(slope.model, slope.scene, options), solver = make(slope.model, slope.scene);
    const double dt = 0.25 * solver->stable_step();
    ASSERT_TRUE(settling->step(2000, dt).ok());
    solver->reset(settling->read());
    const double before = solver->momentum().linear.x();
    ASSERT_TRUE(solver->step(300, dt).ok());
    const double acceleration = (solver->momentum().linear.x() - before) / (300 * dt) / total_mass(slope.model);
    EXPECT_NEAR(acceleration, expected, 1e-3 * free_fall);
    const ToolForce force = solver->tool_force("floor");
    EXPECT_NEAR(force.mean_force.x() / -force.mean_force.z(), 0.5, 1e-4);
  }
}

TEST_P(Contact, ComplianceLetsParticlesInByForceTimesCompliance) {
  Slope level(0.0, 0.0);
  level.scene.remove_tool("floor").add_tool("floor", {.shape = HalfSpace{}, .compliance = 1e-3});
  const auto solver = make(level.model, level.scene, damped(200.0));
  ASSERT_TRUE(solver->run_to_rest(20000, 0.25 * solver->stable_step()).converged());
  const State state = solver->read();
  double pushed = 0.0;
  for (const Index i : level.model.group("z0")) pushed += std::max(0.0, -state.position[i].z() / 1e-3);
  const double weight = total_mass(level.model) * free_fall;
  EXPECT_NEAR(pushed, weight, 1e-4 * weight);
  EXPECT_NEAR(-solver->tool_force("floor").force.z(), weight, 1e-4 * weight);
}

TEST_P(Contact, TakesFromTheBodyWhatTheToolFeels) {
  const Model model = soft_block({0.03, 0.02, 0.02}, 6, 4, 4);
  Scene scene(model);
  ToolPose pose{.position = {0.012, 0.011, 0.031}, .velocity = {0.3, -0.2, -1.0}, .spin = {5, -3, 20}};
  scene.add_tool("ball", {.shape = Sphere{0.01}, .pose = pose, .friction = 0.4});
  pose.position = {0.015, 0.01, -0.008};
  pose.velocity = {0, 0.1, 0.8};
  scene.add_tool("block", {.shape = Box{{0.008, 0.006, 0.006}}, .pose = pose, .friction = 0.7});
  const auto solver = make(model, scene, uncut());  // a cut force has no counterpart
  const double dt = 0.3 * solver->stable_step();
  double largest = 0.0;
  for (int k = 0; k < 60; ++k) largest = std::max(largest, balanced_step(*solver, {"ball", "block"}, dt));
  EXPECT_GT(largest, 0.1);  // N: they did meet
}

TEST_P(Contact, ThinToolAtTwoMetresASecondDoesNotPassThroughACentimetre) {
  const Model model = soft_block({0.03, 0.03, 0.01}, 6, 6, 2);
  Scene scene(model);
  const double half = 1e-4;
  const ToolPose pose{.position = {0.015, 0.015, 0.012}, .velocity = {0, 0, -2.0}};
  scene.add_tool("blade", {.shape = Box{{0.02, 0.02, half}}, .pose = pose});
  const auto solver = make(model, scene);
  const double dt = 0.45 * solver->stable_step();
  ASSERT_GT(2.0 * dt, 2.0 * half);  // it jumps over its own thickness at each step
  for (double gone = 0.0; gone < 0.05; gone += 2.0 * dt) {
    ASSERT_TRUE(is_ok(solver->step(1, dt)));
    const double face = solver->tool_pose("blade").position.z() - half;
    for (const Vec3& x : solver->read().position) ASSERT_LE(x.z(), face + 1e-6 * half + 4 * roundoff());
  }
}

TEST_P(Contact, FastParticlesDoNotPassThroughAThinTool) {
  Model model = soft_block({0.01, 0.01, 0.01}, 2, 2, 2);
  Scene scene(model);
  scene.add_tool("wall", {.shape = Box{{0.05, 0.05, 1e-4}}, .pose = {.position = {0, 0, -0.005}}});
  const auto solver = make(model, scene);
  State state = solver->read();
  for (Vec3& v : state.velocity) v = {0, 0, -20.0};
  solver->reset(state);
  const double dt = 0.4 * solver->stable_step();
  ASSERT_GT(20.0 * dt, 1e-3);
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(solver->step(1, dt).ok());
    for (const Vec3& x : solver->read().position) ASSERT_GE(x.z(), -0.0049 - 4 * roundoff());
  }
}

/// A walk that stays within reach of the body, and lets tools hit it at any angle and turn in it.
ToolPose random_pose(std::mt19937& bits) {
  ToolPose pose;
  pose.position = Vec3(0.01, 0.01, 0.01) + 0.016 * random_vector(bits, 3);
  const double z = uniform(bits) + 1e-3, y = uniform(bits), x = uniform(bits), w = uniform(bits);
  pose.orientation = Quaternion(w, x, y, z).normalized();
  return pose;
}

TEST_P(Contact, TenThousandStepsOfRandomToolsDoNoHarm) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  const std::vector<Index> corner{0};
  scene.fix(corner);  // so that it does not fly off for good
  const ToolPose away{.position = {0.5, 0, 0}};
  scene.add_tool("ball", {.shape = Sphere{0.006}, .pose = away, .friction = 0.5});
  scene.add_tool("rod", {.shape = Capsule{0.005, 0.03}, .pose = away, .friction = 0.2, .compliance = 1e-2});
  const auto solver = make(model, scene, damped(50.0));
  const double dt = 0.25 * solver->stable_step();
  std::mt19937 bits(11);
  int touched = 0;
  const int calls = GetParam().starts_with("gl") ? 40 : 200;  // a software renderer takes its time
  for (int k = 0; k < calls; ++k) {
    scene.tool("ball").move_to(random_pose(bits));
    scene.tool("rod").move_to(random_pose(bits));
    ASSERT_TRUE(is_ok(solver->step(50, dt)));
    touched += solver->tool_force("ball").particles;
    EXPECT_LE(displacement_norms(model, solver->read()).max, 0.2);
  }
  EXPECT_GT(touched, calls / 6);
  scene.remove_tool("ball").remove_tool("rod");
  EXPECT_TRUE(solver->run_to_rest(40000, dt).converged());
  EXPECT_LE(displacement_norms(model, solver->read()).max, 0.1);
}

/// Lattice coordinates that grow from `fine` by `ratio` after `uniform` cells, up to `length`.
std::vector<double> graded(double fine, int uniform, double ratio, double length) {
  std::vector<double> x{0.0};
  for (double step = fine; x.back() < length * (1.0 - 1e-9);) {
    if (static_cast<int>(x.size()) > uniform) step *= ratio;
    x.push_back(x.back() + step);
  }
  return x;
}

/// A quarter of an elastic half-space below z = 0, fine where a ball touches it at the origin.
struct QuarterSpace {
  Model model;
  double depth;  // m
  explicit QuarterSpace(double contact, int cells) {
    const auto x = graded(contact / cells, static_cast<int>(1.5 * cells) + 1, 1.35, 12 * contact);
    const auto z = graded(contact / cells, cells, 1.35, 12 * contact);
    const int nx = static_cast<int>(x.size()) - 1, nz = static_cast<int>(z.size()) - 1;
    model = make_block(Vec3(nx, nx, nz), nx, nx, nz);
    for (Vec3& p : model.rest) p = {x[std::lround(p.x())], x[std::lround(p.y())], -z[nz - std::lround(p.z())]};
    set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000.0});
    depth = z.back();
  }
  /// No motion through the planes of symmetry, none at the bottom.
  void hold(Scene& scene) const {
    scene.fix("z0");
    for (int axis = 0; axis < 2; ++axis) {
      Load load{.type = LoadType::translation, .particles = model.group(axis == 0 ? "x0" : "y0")};
      load.axes.fill(Axis::free);
      load.axes[axis] = Axis::held;
      scene.add(load);
    }
  }
};

/// Force of a ball pressed into the body over Hertz' F = 4/3 E / (1 - nu^2) sqrt(R) d^(3/2), a quarter of it, for a
/// layer of finite depth bonded to its ground (E. K. Dimitriadis et al., Biophys. J. 82 (2002) 2798-2810, eq. 11, to
/// order 2).
double force_over_hertz(int cells) {
  const double radius = 0.02, indentation = 0.8e-3, contact = std::sqrt(radius * indentation);
  const QuarterSpace body(contact, cells);
  Scene scene(body.model);
  body.hold(scene);
  scene.add_tool("ball", {.shape = Sphere{radius}, .pose = {.position = {0, 0, radius}}});
  const SolverOptions options{.damping = {.rate = 2.0 * std::sqrt(10e3 / 1000.0) / (12 * contact)},
                              .rest_tolerance = 1e-5};
  const auto solver = make_solver("cpu", body.model, scene, {}, options);
  const double dt = 0.5 * solver->stable_step();
  scene.tool("ball").move_to({.position = {0, 0, radius - indentation}});
  EXPECT_TRUE(solver->step(300, dt).ok());
  EXPECT_TRUE(has_converged(solver->run_to_rest(20000, dt)));
  const double nu = 0.3, alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu), chi = contact / body.depth;
  const double layer = 1.0 - 2.0 * alpha / M_PI * chi + std::pow(2.0 * alpha / M_PI * chi, 2);
  const double hertz = 4.0 / 3.0 * 10e3 / (1.0 - nu * nu) * std::sqrt(radius) * std::pow(indentation, 1.5) / 4.0;
  return solver->tool_force("ball").force.z() / (hertz * layer);
}

TEST(ContactHertz, SphereOnHalfSpaceMeetsItWithinTenPercentAndConverges) {
  const double coarse = force_over_hertz(1), fine = force_over_hertz(3);
  EXPECT_NEAR(coarse, 1.0, 0.25);
  EXPECT_NEAR(fine, 1.0, 0.1);
  EXPECT_LT(std::abs(fine - 1.0), std::abs(coarse - 1.0));
}

// Friction of contacts that press for some rounds of a step and then no more.

using namespace test;

Model slab(const Vec3& size, const Vec3& at, double density) {
  Model model = with_material(make_block(size, 1, 1, 1), {5e3, 0.3, density});
  return moved(std::move(model), at);
}

/// A small block in the corner between a floor and a wall, both heavy, that comes to both in one step. The wall goes up
/// and lifts it, so that the floor, which came first, has nothing more to press against: and then does not rub either.
TEST(ContactFriction, OfAReleasedContactIsTakenBack) {
  constexpr double skin = 1e-4, mu = 0.5, heavy = 1e9;
  const Model floor = slab({0.10, 0.10, 0.01}, {-0.05, -0.05, -0.01}, heavy),
              wall = slab({0.01, 0.12, 0.10}, {-0.01, -0.06, -0.05}, heavy),
              block = slab({0.005, 0.005, 0.005}, {2.0001 * skin, 0.002, 2.0001 * skin}, 1000.0);
  const std::array<NamedBody, 3> bodies{NamedBody{"floor", &floor}, {"wall", &wall}, {"block", &block}};
  const Model model = merge_models(bodies);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = Scene(model).contacts({.friction = mu, .margin = skin});
    const auto solver = make_solver(backend, model, scene, {}, {.on_unstable = UnstableStep::allow});
    State start = rest_state(model);
    const Vec3 thrown(-0.2, 2.0, -0.02);  // m/s
    for (const Index i : model.group("wall")) start.velocity[i] = {0, 0, 2.0};
    for (const Index i : model.group("block")) start.velocity[i] = thrown;
    solver->reset(start);
    ASSERT_TRUE(is_ok(solver->step(1, 1e-5)));
    const State end = solver->read();
    const double rounding = backend[0] == 'r' ? 1e-9 : 1e-5;
    int met_both = 0;
    for (const Index i : model.group("block")) {
      const Vec3 gained = end.velocity[i] - thrown;
      if (model.rest[i].x() > 0.002 || model.rest[i].z() > 0.002) continue;
      ++met_both;
      EXPECT_NEAR(gained.x(), 0.2, 0.002) << backend;
      EXPECT_GT(end.velocity[i].z(), 0.0) << backend;  // lifted: off the floor
      EXPECT_NEAR(std::hypot(gained.y(), gained.z()), mu * gained.x(), rounding) << backend;
    }
    EXPECT_EQ(met_both, 2);
  }
}

}  // namespace
}  // namespace phymul::test
