// SPDX-License-Identifier: MIT
//
// Tools: what is imposed takes its part of a push by itself, what leaves by itself is not held back, and where a tool
// goes between two poses.
#include <algorithm>
#include <cmath>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

using ToolEffects = WithTools;
PHYMUL_ON_EVERY_BACKEND(ToolEffects);

/// A ball whose centre is out of the plane pushes a flat body askew, and feels it only in the plane.
TEST_P(ToolEffects, NothingOutOfAFlatBodysPlane) {
  const Model model = make_strip(0.04, 0.02, 8, 4);
  Scene scene(model);
  scene.fix("y0").add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.02, 0.0264, 0.004}}});
  const auto solver = make(model, scene);
  double most = 0.0;
  for (int k = 1; k <= 20; ++k) {
    scene.tool("ball").move_to({.position = {0.02, 0.0264 - 1e-4 * k, 0.004}});
    ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
    const Vec3& force = solver->tool_force("ball").force;
    EXPECT_EQ(force.z(), 0.0) << k;
    most = std::max(most, force.norm());
  }
  EXPECT_GT(most, 1e-6);
}

/// Likewise where loads impose one coordinate of what it pushes.
TEST_P(ToolEffects, NothingAlongAnImposedAxis) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  for (int axis = 0; axis < 2; ++axis) {
    Scene scene = Scene(model).fix("z0");
    Load held{
        .type = LoadType::translation, .particles = model.group("z1"), .axes = {Axis::free, Axis::free, Axis::free}};
    held.axes[static_cast<std::size_t>(axis)] = Axis::held;
    scene.add(held);
    // Between lattice points, so that it pushes aside whatever it meets.
    const Vec3 above(0.0085, 0.0085, 0.028);
    scene.add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = above}, .friction = 0.4});
    const auto solver = make(model, scene);
    double most = 0.0;
    for (int k = 1; k <= 10; ++k) {
      scene.tool("ball").move_to({.position = above - Vec3(0, 0, 2e-4 * k)});
      ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
      const Vec3& force = solver->tool_force("ball").force;
      EXPECT_EQ(force[axis], 0.0) << axis << ", " << k;
      most = std::max(most, std::abs(force[1 - axis]));
    }
    EXPECT_GT(most, 1e-3);
  }
}

/// A floor put over what is on its way out of it: that comes out, and nothing draws it back.
TEST_P(ToolEffects, NothingOfWhatLeavesByItself) {
  const Model model = make_block({0.01, 0.01, 0.01}, 1, 1, 1);
  Scene scene(model);
  constexpr double deep = 1e-4;  // m
  scene.add_tool("floor", {.shape = HalfSpace{}, .pose = {.position = {0, 0, deep}}});
  const auto solver = make(model, scene, {.on_unstable = UnstableStep::allow});
  const double dt = 0x1p-10;
  State state = rest_state(model);
  for (Vec3& v : state.velocity) v = {0, 0, 0.5 * deep / dt};
  solver->reset(state);
  ASSERT_TRUE(solver->step(1, dt).ok());
  const State end = solver->read();
  EXPECT_LE(solver->tool_force("floor").force.norm() * dt, 1e4 * roundoff() * 0.5 * deep / dt);  // N s, of 1 kg each
  for (const Vec3& v : end.velocity) EXPECT_NEAR(v.z(), 0.5 * deep / dt, 1e4 * roundoff() * deep / dt);
  for (const Index i : model.group("z0")) EXPECT_NEAR(end.position[i].z(), deep, 1e3 * roundoff() * 0.01);
}

/// What loads hold with all its coordinates takes no push, and the tool neither feels nor counts it.
TEST_P(ToolEffects, WhatIsImposedWholeIsNotCounted) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  scene.fix("z0").fix("z1").add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.027}}});
  const auto solver = make(model, scene);
  ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
  EXPECT_EQ(solver->tool_force("ball").particles, 0);
  EXPECT_EQ(solver->tool_force("ball").force, Vec3::Zero());
}

/// Head first: with the cap that is further along its axis.
TEST_P(ToolEffects, ARodTouchesWithItsFarCap) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  const double radius = 0.002, length = 0.03, deep = 1e-4;  // m
  const ToolPose down{.position = {0.01, 0.01, 0.02 + length + radius - deep}, .orientation = {0, 1, 0, 0}};
  scene.fix("z0").add_tool("rod", {.shape = Capsule{radius, length}, .pose = down});
  const auto solver = make(model, scene);
  ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
  EXPECT_EQ(solver->tool_force("rod").particles, 1);
  EXPECT_GT(solver->tool_force("rod").force.z(), 0.0);
}

/// A rod that turns by 60 degrees in one step reaches further out on its way than where it begins and ends.
TEST(ToolSwing, MeetsWhatIsBeyondTheChord) {
  const double length = 0.02;
  const Model model = moved(make_block(Vec3::Constant(5e-4), 1, 1, 1), {0, -2.5e-4, 0.93 * length});
  const auto turned = [](double angle) { return Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitX())); };
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(model);
    scene.add_tool("rod", {.shape = Capsule{5e-4, length}, .pose = {.orientation = turned(M_PI / 6)}});
    const auto solver = make_solver(backend, model, scene);
    scene.tool("rod").move_to({.orientation = turned(-M_PI / 6)});
    ASSERT_TRUE(solver->step(1, 0.3 * solver->stable_step()).ok());
    EXPECT_GT(solver->tool_force("rod").particles, 0) << backend;
  }
}

/// As the last step of a loop of `advance(min(tick, end - time))`, but long enough to be one: single precision leaves
/// places off by more than such a step goes.
TEST(ToolRemainder, IsNoBlow) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  for (const char* backend : {"reference", "cpu"}) {
    for (const bool holds : {false, true}) {
      for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
        Scene scene(model);
        ToolPose pose{.position = {0.0103, 0.0098, 0.0235}};
        const ToolHandle plate =
            scene.fix("z0").add_tool("plate", {.shape = Box{{0.012, 0.012, 0.002}}, .pose = pose, .contact = contact});
        if (holds) plate.grasp(2.5e-3);
        const auto solver = make_solver(backend, model, scene, {}, damped(150.0));
        const double dt = 0.4 * solver->stable_step();
        ASSERT_TRUE(solver->step(1, dt).ok());
        pose.position.z() -= 2.2e-3;
        plate.move_to(pose);
        for (int k = 0; k < 2; ++k) ASSERT_TRUE(solver->step(200, dt).ok());
        ASSERT_GT(solver->tool_force("plate").force.z(), 0.1);
        for (const double remainder : {2.3e-14, 2e-6 * dt}) {
          EXPECT_LT(solver->step(1, remainder).max_speed, 1e-4)
              << backend << holds << (contact == ToolContact::surface);
        }
        EXPECT_TRUE(solver->step(100, dt).ok());
      }
    }
    Scene scene(model);
    scene.fix("z0").gravity({0, 0, -9.81}).constrain_volume();
    const auto solver = make_solver(backend, model, scene, {}, damped(150.0));
    const double dt = 0.4 * solver->stable_step();
    ASSERT_TRUE(solver->step(400, dt).ok());
    for (const double remainder : {2.3e-14, 2e-6 * dt}) {
      EXPECT_LT(solver->step(1, remainder).max_speed, 1e-2) << backend;
    }
    EXPECT_TRUE(solver->step(100, dt).ok());
  }
}

/// Of ToolContact::surface: what a step leaves inside is more than what the short ones after it leave.
TEST(ToolSteps, ShortOnesThatFollowPressNoHarder) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 3, 3, 3);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene(model);
    ToolPose pose{.position = {0.0103, 0.0098, 0.0235}};
    const ToolHandle box = scene.fix("z0").add_tool(
        "box", {.shape = Box{{0.006, 0.006, 0.002}}, .pose = pose, .contact = ToolContact::surface});
    const auto solver = make_solver(backend, model, scene, {}, damped(150.0));
    const double dt = 0.4 * solver->stable_step();
    ASSERT_TRUE(solver->step(1, dt).ok());
    pose.position.z() -= 2.2e-3;
    box.move_to(pose);
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(solver->step(100, dt).ok());
    const double rest = solver->tool_force("box").force.z();
    ASSERT_GT(rest, 0.1);
    const int particles = solver->tool_force("box").particles;
    for (const double share : {0.3, 2e-3}) {
      for (int k = 0; k < 5; ++k) {
        ASSERT_TRUE(solver->step(1, share * dt).ok());
        const ToolForce now = solver->tool_force("box");
        EXPECT_LT(now.force.z(), 1.5 * rest) << backend << ' ' << share << ' ' << k;
        EXPECT_GT(now.force.z(), 0.5 * rest) << backend << ' ' << share << ' ' << k;
        EXPECT_LE(now.particles, particles);
      }
      ASSERT_TRUE(solver->step(100, dt).ok());
    }
  }
}

// Friction of tools with ToolContact::surface: what sticks does not creep, what slides does so at Coulomb's limit.

/// Two plates that close on a body from above and below, and then go along x.
struct Plates {
  Scene scene;
  std::unique_ptr<Solver> solver;
  double x = 0.0, gap = 0.0, half_thickness = 0.0, dt = 0.0;

  struct Shape {
    Vec3 half_size;
    double friction, x, open;  // -, m, m
  };
  Plates(const Scene& of, const Shape& plates)
      : scene(of.copy()), x(plates.x), gap(plates.open), half_thickness(plates.half_size.z()) {
    for (int k = 0; k < 2; ++k) {
      scene.add_tool(k == 0 ? "upper" : "lower", {.shape = Box{plates.half_size},
                                                  .pose = pose(k),
                                                  .friction = plates.friction,
                                                  .contact = ToolContact::surface});
    }
    solver = make_solver("cpu", scene.model(), scene, {}, damped(50.0));
    dt = 0.5 * solver->stable_step();
  }
  ToolPose pose(int k) const { return {.position = {x, 0.0, (k == 0 ? 1.0 : -1.0) * (0.5 * gap + half_thickness)}}; }

  void go(double to_x, double to_gap, double seconds) {
    const int calls = std::max(1, static_cast<int>(std::lround(seconds / 2e-3)));
    const double from_x = x, from_gap = gap;
    for (int call = 1; call <= calls; ++call) {
      x = from_x + (to_x - from_x) * call / calls;
      gap = from_gap + (to_gap - from_gap) * call / calls;
      scene.tool("upper").move_to(pose(0));
      scene.tool("lower").move_to(pose(1));
      ASSERT_TRUE(is_ok(solver->step(std::max(1, static_cast<int>(2e-3 / dt)), dt)));
    }
  }
  Vec3 force(const char* plate) const { return solver->tool_force(plate).mean_force; }
  double normal() const { return 0.5 * (force("upper").z() - force("lower").z()); }
  double shear() const { return -(force("upper").x() + force("lower").x()); }
};

std::vector<Index> particles_where(const Model& model, const Contains& is_in) {
  std::vector<Index> found;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (is_in(model.rest[i])) found.push_back(i);
  }
  return found;
}

const Material gel{.young = 5e3, .poisson = 0.45, .density = 1000.0};

/// Of some 1,400 particles.
Model ellipsoid(const Material& material) {
  return with_material(make_body(solid_ellipsoid({0, 0, 0}, {0.06, 0.03, 0.02}), {.spacing = 0.0063}), material);
}

TEST(ToolFriction, APinchedTipStaysBetweenThePlates) {
  const Model model = ellipsoid(gel);
  Scene scene(model);
  scene.fix(particles_where(model, [](const Vec3& at) { return at.x() < -0.03; }));
  Plates plates(scene, {.half_size = {0.005, 0.01, 0.002}, .friction = 0.8, .x = 0.052, .open = 0.03});
  plates.go(plates.x, 0.006, 0.4);
  plates.go(plates.x, 0.006, 0.3);
  const double normal = plates.normal(), from = plates.x;
  const State closed = plates.solver->read();
  // Within half of the plates, where no edge strips them.
  std::vector<Index> pinched;
  for (Index i = 0; i < model.particle_count(); ++i) {
    const Vec3 off = closed.position[i] - Vec3(from, 0, 0);
    if (std::abs(off.x()) < 0.004 && std::abs(off.y()) < 0.008 && std::abs(std::abs(off.z()) - 0.003) < 1e-3) {
      pinched.push_back(i);
    }
  }
  ASSERT_GE(pinched.size(), 4u);
  plates.go(from + 0.02, 0.006, 1.0);
  plates.go(from + 0.02, 0.006, 0.5);
  const State pulled = plates.solver->read();
  double slip = 0.0;
  for (const Index i : pinched) {
    slip = std::max(slip, std::abs(0.02 - (pulled.position[i] - closed.position[i]).x()));
  }
  RecordProperty("slip_mm", std::to_string(1e3 * slip));
  RecordProperty("normal", std::to_string(normal) + " to " + std::to_string(plates.normal()));
  RecordProperty("shear", std::to_string(plates.shear()));
  EXPECT_LE(slip, 0.2e-3);
  EXPECT_GE(plates.normal(), 0.9 * normal);
  EXPECT_GE(plates.shear(), 0.5);  // N: it pulls the body along
}

/// Plates that cover a body whose middle layer is held. A bag: soft, and its volume is kept.
TEST(ToolFriction, SlidesAtCoulombsLimitOverBlockEllipsoidAndBag) {
  Model block = make_block({0.06, 0.03, 0.02}, 12, 6, 4);
  for (Vec3& at : block.rest) at -= Vec3(0.03, 0.015, 0.01);
  const Model flat = with_material(block, gel), round = ellipsoid(gel),
              bag = ellipsoid({.young = 2e3, .poisson = 0.3, .density = 1000.0});
  constexpr double friction = 0.3;
  for (const Model* model : {&flat, &round, &bag}) {
    const double half = model == &flat ? 0.01 : 0.02;
    Scene scene(*model);
    scene.fix(particles_where(*model, [&](const Vec3& at) { return std::abs(at.z()) < 0.3 * half; }));
    if (model == &bag) scene.constrain_volume();
    Plates plates(scene, {.half_size = {0.2, 0.2, 0.004}, .friction = friction, .x = 0.0, .open = 2.4 * half});
    plates.go(0.0, 1.4 * half, 0.4);
    plates.go(0.0, 1.4 * half, 0.2);
    plates.go(0.015, 1.4 * half, 1.5);
    EXPECT_NEAR(plates.shear() / (2.0 * friction * plates.normal()), 1.0, 0.1) << (model == &flat    ? "block"
                                                                                   : model == &round ? "ellipsoid"
                                                                                                     : "bag");
  }
}

}  // namespace

}  // namespace phymul::test
