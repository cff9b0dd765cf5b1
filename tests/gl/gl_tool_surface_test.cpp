// SPDX-License-Identifier: MIT
//
// Tools with ToolContact::surface on the GL backends: against the double reference, and what scenes without them pay.
// What the law promises: tests/interaction/tool_surface_test.cpp, on every backend.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "support/gl_block.h"
#include "support/gl_needles.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

/// Calibrated: five times the largest of what the tests below print on llvmpipe, 8e-7 of the motion and 1.1e-5 of the
/// largest force, and what the scene makes of roundings, `rounded`, m and N. A capsule pressed in by 12 of 20 mm makes
/// 1.7e-4 and 2.4e-4 of them; llvmpipe is off there by 1.2e-5 and 3.2e-5, an NVIDIA H100 by 2.4e-5 and 1.3e-4.
void expect_near(double apart, double moved, double force_apart, double force,
                 std::array<double, 2> rounded = {0.0, 0.0}) {
  std::printf(
      "[ SURFACE ] off the reference by at most %.2g m of %.2g, and by %.2g N of %.2g; roundings make %.2g, %.2g\n",
      apart, moved, force_apart, force, rounded[0], rounded[1]);
  EXPECT_LE(apart, 4e-6 * moved + rounded[0]);
  EXPECT_LE(force_apart, 5e-5 * force + rounded[1]);
}

class GlToolSurface : public GlBlockTest {
 protected:
  /// The device beside the reference, and by how much they are apart. The reference runs a second time, from places
  /// that are off by what two hundred steps in single precision round, a random walk: a body that buckles makes much of
  /// it.
  struct Pair {
    std::unique_ptr<gl::DeviceSolver> device;
    std::unique_ptr<Solver> reference, rounded;
    double apart = 0.0, rounded_apart = 0.0, moved = 0.0;              // m, largest so far; of the body
    double force_apart = 0.0, rounded_force_apart = 0.0, force = 0.0;  // N, largest so far; on a tool

    void step(int steps, double dt) {
      ASSERT_TRUE(all_step(steps, dt, device, reference, rounded));
      const State a = device->read(), b = reference->read();
      apart = std::max(apart, largest_distance(a.position, b.position));
      rounded_apart = std::max(rounded_apart, largest_distance(rounded->read().position, b.position));
      moved = std::max(moved, largest_distance(b.position, reference->model().rest));
      for (const ToolState& tool : b.tools) {
        const ToolForce &own = device->tool_force(tool.name), &exact = reference->tool_force(tool.name);
        force = std::max(force, exact.mean_force.norm());
        force_apart = std::max(force_apart, (own.mean_force - exact.mean_force).norm());
        force_apart = std::max(force_apart, (own.force - exact.force).norm());
        const ToolForce& other = rounded->tool_force(tool.name);
        rounded_force_apart = std::max(rounded_force_apart, (other.force - exact.force).norm());
        EXPECT_LE((own.torque - exact.torque).norm(), 1e-4 * (exact.torque.norm() + 0.01 * exact.force.norm()) + 1e-9);
        EXPECT_EQ(device->tool_pose(tool.name), reference->tool_pose(tool.name));
      }
      EXPECT_EQ(a.tools.size(), b.tools.size());
      for (std::size_t row = 0; row < a.tools.size(); ++row) EXPECT_EQ(a.tools[row].held, b.tools[row].held);
    }
  };
  Pair pair_of(const Scene& scene) const {
    const auto tables = &scene.model() == &model_ ? tables_ : tables_of(scene.model(), {});
    const auto reference = [&] { return make_solver("reference", tables, scene, options_); };
    Pair both{std::make_unique<gl::DeviceSolver>(GetParam(), tables, scene, options_), reference(), reference()};
    State start = both.rounded->read();
    const double rounding = 0.5 * std::numeric_limits<float>::epsilon() * body_size(scene.model());
    std::mt19937 bits(7);
    for (Vec3& x : start.position) x += std::sqrt(200.0) * rounding * random_vector(bits, 3);
    both.rounded->reset(start);
    return both;
  }
  static void expect_close(const Pair& both) {
    expect_near(both.apart, both.moved, both.force_apart, both.force, {both.rounded_apart, both.rounded_force_apart});
  }
};

PHYMUL_ON_BOTH_DEVICES(GlToolSurface);

/// Down into the top, on with a speed and a turn, put somewhere else, and out again. Every other shape 1.4 km away.
TEST_P(GlToolSurface, EveryShapeAgreesWithTheReference) {
  bool far = false;
  std::vector<Tool> tools = tools_of_each_shape();
  tools.insert(tools.begin(), {.shape = Sphere{0.005}});
  for (Tool tool : tools) {
    const Vec3 origin = far ? Vec3(800, -600, 1000) : Vec3(0, 0, 0);
    far = !far;
    const Model model = moved(model_, origin);
    tool.contact = ToolContact::surface;
    tool.pose = above(origin + Vec3(0.014, 0.011, 0.03));
    Scene scene = Scene(model).fix("z0").gravity({0, 0, -2}).add_tool("tool", tool);
    Pair both = pair_of(scene);
    drive(
        scene.tool("tool"), origin, [&](int) { both.step(9, dt_); }, sanitized ? 6 : 22);
    EXPECT_GT(both.moved, 3e-4);
    EXPECT_GT(both.force, 0.01) << "N; or this shows nothing";
    expect_close(both);
  }
}

/// A step of sixty rounds that moves particles without a speed.
TEST_P(GlToolSurface, APlacedToolLetsTheSurfaceOutAsTheReferenceDoes) {
  Scene scene = Scene(model_).fix("z0").add_tool(
      "ball", {.shape = Sphere{0.007}, .pose = {.position = {0, 0, 0.5}}, .contact = ToolContact::surface});
  Pair both = pair_of(scene);
  scene.tool("ball").teleport({.position = {0.0141, 0.0103, 0.0255}});
  both.step(1, dt_);
  EXPECT_GT(both.moved, 1e-3);
  expect_close(both);
  for (int k = 0; k < 20; ++k) both.step(5, dt_);
  expect_close(both);
}

/// Tools of both kinds in turn, one of which holds particles that others must not push; some coordinates are imposed.
TEST_P(GlToolSurface, ToolsActOneAfterAnotherAroundAGrasp) {
  Scene scene = Scene(model_).fix("z0").add({.type = LoadType::translation,
                                             .particles = model_.group("x0"),
                                             .events = {{0.0, 0.0}},
                                             .axes = {Axis::held, Axis::free, Axis::free}});
  const Tool ball{.shape = Sphere{0.005}, .friction = 0.3, .contact = ToolContact::surface};
  const auto add = [&](const char* name, Tool tool, const Vec3& position) {
    tool.pose = {.position = position};
    scene.add_tool(name, tool);
  };
  add("first", ball, {0.009, 0.01, 0.0262});
  add("plain", {.shape = Sphere{0.005}, .friction = 0.2}, {0.015, 0.01, 0.0262});
  add("jaw", {.shape = Box{{0.002, 0.03, 0.0015}}}, {0.025, 0.01, 0.021});
  add("last", ball, {0.021, 0.012, 0.0262});
  Pair both = pair_of(scene);
  std::map<std::string, double> largest;  // N
  for (int k = 0; k < 30; ++k) {
    const double down = 1e-4 * std::min(k, 20);
    if (k == 2) scene.tool("jaw").grasp(1e-4);
    if (k == 6) scene.tool("jaw").move_to({.position = {0.0255, 0.0105, 0.0215}, .velocity = {0, 0.01, 0}});
    if (k == 22) scene.tool("jaw").release();
    const ToolPose first{.position = {0.009, 0.01, 0.0262 - down}};
    k == 12 ? scene.tool("first").teleport({.position = {0.009, 0.0105, 0.0243}}) : scene.tool("first").move_to(first);
    scene.tool("plain").move_to({.position = {0.015, 0.01, 0.0262 - down}});
    scene.tool("last").move_to({.position = {0.021, 0.012, 0.0262 - down}});
    both.step(7, dt_);
    EXPECT_EQ(both.reference->read().tools.at(2).held.empty(), k < 2 || k >= 22);
    for (const char* name : {"first", "plain", "jaw", "last"}) {
      largest[name] = std::max(largest[name], both.reference->tool_force(name).mean_force.norm());
    }
  }
  for (const auto& [name, force] : largest) EXPECT_GT(force, 0.01) << name << ", N; or this shows less";
  expect_close(both);
}

/// With the passes that contacts and kept volumes put between forces and motion as well. Bodies that touch amplify
/// what floats round: as where there are no tools (gl_joint_test.cpp).
TEST_P(GlToolSurface, AgreesBesideContactsAndVolumes) {
  const Model lower = make_block({0.02, 0.02, 0.02}, 3, 3, 3), upper = moved(lower, {0, 0, 0.021});
  const Model model = with_material(merged({{"lower", &lower}, {"upper", &upper}}));
  Scene scene = Scene(model).fix("lower/z0").gravity({0, 0, -9.81}).contacts({}).constrain_volume("upper");
  scene.add_tool("ball", {.shape = Sphere{0.006},
                          .pose = {.position = Vec3(0.012, 0.009, 0.0472), .velocity = {0, 0, -0.02}},
                          .contact = ToolContact::surface});
  BesideReference both(model, scene, {}, GetParam());
  EXPECT_LE(both.off_after(sanitized ? 20 : 120), 1e-3);
  const ToolForce &own = both.device->tool_force("ball"), &exact = both.reference->tool_force("ball");
  EXPECT_GT(exact.mean_force.norm(), 1e-3) << "N; or this shows nothing";
  EXPECT_LE((own.mean_force - exact.mean_force).norm(), 1e-3 * exact.mean_force.norm());
}

class GlToolSurfaceWithNeedle : public OnCompute {};

/// Needles come before what presses, whatever its place in the scene.
TEST_F(GlToolSurfaceWithNeedle, ActsBesideANeedleAsOnTheReference) {
  BesideNeedle both(0.0);
  const auto add = [&](const char* name, const Vec3& position, ToolContact contact) {
    both.scene.add_tool(name,
                        {.shape = Sphere{0.006}, .pose = {.position = position}, .friction = 0.3, .contact = contact});
  };
  add("ball", {0.012, 0.02, block_side + 0.0055}, ToolContact::surface);
  add("plain", {0.03, 0.02, block_side + 0.0055}, ToolContact::particles);
  double apart = 0.0, moved = 0.0, force_apart = 0.0, force = 0.0;
  std::size_t nodes = 0;
  std::map<std::string, double> largest;  // N
  for (int k = 1; k <= 12; ++k) {
    both.pose.position.z() -= 1e-3;
    both.scene.tool("ball").move_to({.position = {0.012, 0.02, block_side + 0.0055 - 2e-4 * k}});
    both.go(0.005);
    const State a = both.device->read(), b = both.reference->read();
    apart = std::max(apart, largest_distance(a.position, b.position));
    moved = std::max(moved, largest_distance(b.position, both.model.rest));
    nodes = std::max(nodes, b.tools.at(0).needle.hole.size());
    for (const char* tool : {"needle", "ball", "plain"}) {
      const Vec3 exact = both.reference->tool_force(tool).mean_force;
      force = std::max(force, exact.norm());
      force_apart = std::max(force_apart, (both.device->tool_force(tool).mean_force - exact).norm());
      largest[tool] = std::max(largest[tool], exact.norm());
    }
  }
  for (const auto& [tool, most] : largest) EXPECT_GT(most, 1e-2) << tool << ", N; or this shows less";
  EXPECT_GT(nodes, 1u) << "or this shows less";
  expect_near(apart, moved, force_apart, force);
}

TEST_P(GlToolSurface, SnapshotsGoOnBitForBitAndLostDevicesGoBack) {
  Scene scene = Scene(model_).fix("z0").add_tool("ball", {.shape = Sphere{0.005},
                                                          .pose = {.position = {0.014, 0.011, 0.0248}},
                                                          .friction = 0.3,
                                                          .contact = ToolContact::surface});
  const auto device = make(scene), other = make(scene);
  scene.tool("ball").move_to({.position = {0.015, 0.011, 0.0235}});
  ASSERT_TRUE(device->step(30, dt_).ok());
  const Snapshot middle = device->snapshot();
  ASSERT_TRUE(device->step(40, dt_).ok());
  const Snapshot end = device->snapshot();
  const ToolForce force = device->tool_force("ball");
  EXPECT_GT(force.force.norm(), 0.01);
  for (gl::DeviceSolver* const solver : {device.get(), other.get()}) {
    solver->restore(middle);
    ASSERT_TRUE(solver->step(40, dt_).ok());
    EXPECT_EQ(solver->snapshot(), end);
    EXPECT_EQ(solver->tool_force("ball").force, force.force);
  }
  copy_and_lose(*device, *other);
}

/// Batches end where the body rests, and are taken back to there.
TEST_P(GlToolSurface, RestsWhereTheReferenceDoes) {
  options_.damping.rate = 200.0;
  options_.rest_tolerance = 1e-4;
  Scene scene = Scene(model_).fix("z0").add_tool(
      "ball", {.shape = Sphere{0.005}, .pose = {.position = {0.014, 0.011, 0.0249}}, .contact = ToolContact::surface});
  const Pair both = pair_of(scene);
  scene.tool("ball").move_to({.position = {0.014, 0.011, 0.0242}});
  for (Solver* const solver : {static_cast<Solver*>(both.device.get()), both.reference.get()}) {
    EXPECT_TRUE(solver->run_to_rest(20000, dt_).converged());
  }
  const ToolForce &own = both.device->tool_force("ball"), &exact = both.reference->tool_force("ball");
  EXPECT_GT(exact.force.norm(), 1e-3);
  EXPECT_LE((own.force - exact.force).norm(), 1e-3 * exact.force.norm());
  EXPECT_NEAR(own.mean_force.z(), exact.mean_force.z(), 1e-3 * exact.mean_force.norm());
}

TEST_P(GlToolSurface, OnlyScenesWithSuchToolsPayForIt) {
  options_.profile = true;
  Scene scene(model_);
  scene.fix("z0").add_tool("plain", {.shape = Sphere{0.005}, .pose = {.position = {0.01, 0.01, 0.0248}}});
  const auto device = make(scene);
  const auto passes = [&] {
    device->clear_profile();
    EXPECT_TRUE(device->step(10, dt_).ok());
    std::vector<std::pair<std::string, std::int64_t>> names;
    for (const auto& run : runs_of(*device)) {
      if (run.second > 0) names.push_back(run);
    }
    return names;
  };
  const auto without = passes();
  const auto of_surfaces = [](const auto& run) { return run.first.starts_with("surface_"); };
  EXPECT_TRUE(std::ranges::none_of(without, of_surfaces));
  scene.add_tool("ball",
                 {.shape = Sphere{0.005}, .pose = {.position = {0.02, 0.01, 0.0248}}, .contact = ToolContact::surface});
  const auto runs = [&] {
    std::int64_t sum = 0;
    for (const auto& run : passes()) sum += of_surfaces(run) ? run.second : 0;
    return sum;
  };
  constexpr int apart_from_rounds = 4;  // start, load, gather, end; a round has two
  EXPECT_EQ(runs(), 10 * (apart_from_rounds + 2 * 6) + 2 * 54) << "it was put there in the first step";
  EXPECT_EQ(runs(), 10 * (apart_from_rounds + 2 * 6));
  scene.remove_tool("ball");
  EXPECT_EQ(passes(), without);
}

}  // namespace
}  // namespace phymul::test
