// SPDX-License-Identifier: MIT
//
// Needles on "gl-compute" against the double reference: over whole insertions, step by step, far from the origin,
// and beside all else that pushes particles.
#include <array>
#include <cmath>

#include "support/gl_needles.h"

namespace phymul::test {
namespace {

using GlNeedle = OnCompute;

/// m. No step ends with a tip on the surface, where rounding decides in which one the hole begins.
constexpr double over_skin = offset + 2.3e-5;

/// What a needle does on its way, and from where it is moved; depths in m.
struct Course {
  const char* name;
  double stiffness;
  Vec3 origin;
  double depth, turn, aside;
};

/// Rise, puncture, plateau and withdrawal; turning; a shaft that bends; out on the far side. Bounds: some ten times of
/// what llvmpipe gave. A stiff shaft that comes out holds nodes that all but coincide, and any rounding then decides
/// where it goes, in the reference too: there is no such course.
TEST_F(GlNeedle, AgreesWithTheReferenceOverWholeInsertions) {
  const Vec3 far(800, -600, 1000);
  const std::array courses{
      Course{"stiff", 0.0, {0, 0, 0}, 0.02, 0.0, 0.0}, Course{"turning, far", 0.0, far, 0.02, 0.4, 0.0},
      Course{"bending", 5e-3, {0, 0, 0}, 0.02, 0.1, 1e-4}, Course{"soft, far", 1e-6, far, 0.025, 0.0, 2e-4},
      Course{"through, bending", 2e-2, far, 0.06, 0.2, 1e-4}};
  for (const Course& course : courses) {
    SCOPED_TRACE(course.name);
    BesideNeedle pair(course.stiffness, 4, course.origin);
    double off = 0.0, moved = 0.0, off_force = 0.0, peak = 0.0, off_bend = 0.0, least = 0.0;
    bool through = false;
    constexpr int parts = 12;
    constexpr double speed = 0.2;  // m/s
    for (int k = 1; k <= 2 * parts; ++k) {
      const double way = course.depth + offset;
      pair.pose.position.z() += (k <= parts ? -1.0 : 1.0) * way / parts;
      pair.pose.position.x() += k > parts / 2 ? course.aside : 0.0;
      pair.pose.orientation = Quaternion(Eigen::AngleAxisd(course.turn * k, Vec3::UnitZ()));
      pair.go(way / parts / speed);
      const State a = pair.device->read(), b = pair.reference->read();
      off = std::max(off, largest_distance(a.position, b.position));
      moved = std::max(moved, largest_distance(b.position, pair.model.rest));
      const ToolForce fa = pair.device->tool_force("needle"), fb = pair.reference->tool_force("needle");
      off_force = std::max(off_force, (fa.mean_force - fb.mean_force).norm());
      peak = std::max(peak, fb.mean_force.norm());
      least = std::min(least, fb.mean_force.z());
      EXPECT_EQ(fa.particles, fb.particles) << k;
      const NeedleState &na = a.tools.at(0).needle, &nb = b.tools.at(0).needle;
      expect_like(na, nb);
      through = through || na.through;
      off_bend = std::max(off_bend, largest_distance(pair.device->needle_points("needle", 5),
                                                     pair.reference->needle_points("needle", 5)));
    }
    EXPECT_TRUE(pair.device->read().tools[0].needle.hole.empty());
    EXPECT_EQ(through, course.depth > block_side);
    EXPECT_GT(moved, 1e-3);
    EXPECT_GT(peak, 0.3);
    EXPECT_LT(least, -0.05);
    std::printf("[ NEEDLES ] %s: off by at most %.2g m of %.2g, forces by %.2g of the peak, the shaft by %.2g m\n",
                course.name, off, moved, off_force / peak, off_bend);
    EXPECT_LE(off, 3e-8);
    EXPECT_LE(off_force, 6e-6 * peak);
    EXPECT_LE(off_bend, 1e-7);
  }
}

/// Both from the device's state, a step each, wherever the needle is: what differs then is rounding of one step.
TEST_F(GlNeedle, AStepIsThatOfTheReference) {
  for (const double stiffness : {0.0, 5e-3}) {
    BesideNeedle pair(stiffness, 4);
    double worst = 0.0, worst_force = 0.0;
    for (int k = 0; k < 30; ++k) {
      pair.pose.position += Vec3(k > 10 ? 1e-4 : 0.0, 0.0, k < 20 ? -1.5e-3 : 1.5e-3);
      pair.go(0.004);
      const State start = pair.device->read();
      pair.device->reset(start);
      pair.reference->reset(start);
      ASSERT_TRUE(all_step(1, pair.dt, pair.device, pair.reference));
      const State a = pair.device->read(), b = pair.reference->read();
      worst = std::max(worst, largest_distance(a.velocity, b.velocity) * pair.dt);
      worst_force = std::max(
          worst_force, (pair.device->tool_force("needle").force - pair.reference->tool_force("needle").force).norm());
      expect_like(a.tools[0].needle, b.tools[0].needle);
    }
    std::printf("[ NEEDLES ] a step off by at most %.2g m, the force by %.2g N\n", worst, worst_force);
    EXPECT_LE(worst, 3e-8);
    EXPECT_LE(worst_force, stiffness > 0.0 ? 1e-5 : 4e-4);
  }
}

/// Nodes by the dozen on a hair, of a needle that is put into a long block: a system of a condition that floats alone
/// do not solve, by 3e-5 m; and more places at once than a dispatch looks at.
TEST_F(GlNeedle, ManyNodesBendASoftShaftAsOnTheReference) {
  const Model model =
      with_material(make_block({0.01, 0.01, 0.1}, 4, 4, 40), {.young = 10e3, .poisson = 0.45, .density = 1000.0});
  Needle hair = bending(1e-6);
  hair.length = 0.12;
  hair.spread = 0.00168;
  ToolPose pose{.position = {0.0053, 0.0049, 0.004}};
  Scene scene = Scene(model).fix("z0").add_tool("needle", {.shape = hair, .pose = pose, .friction = 0.5});
  BesideReference pair(model, scene, damped(40.0));
  double worst = 0.0, worst_bend = 0.0, bent = 0.0;
  constexpr int calls = 8;
  for (int k = 0; k < calls; ++k) {
    pose.position.x() += 1.6e-3 / calls;
    scene.tool("needle").move_to(pose);
    pair.off_after(12);
    worst = std::max(worst, largest_distance(pair.device->read().position, pair.reference->read().position));
    const VecList x = pair.device->needle_points("needle", 7), y = pair.reference->needle_points("needle", 7);
    worst_bend = std::max(worst_bend, largest_distance(x, y));
    bent = std::max(bent, (y.front() - pose.position).norm());
    expect_like(pair.device->read().tools[0].needle, pair.reference->read().tools[0].needle);
  }
  const std::size_t nodes = pair.device->read().tools[0].needle.shaft.size();
  std::printf("[ NEEDLES ] %zu nodes: off by %.2g m, the shaft by %.2g m of %.2g\n", nodes, worst, worst_bend, bent);
  EXPECT_GE(nodes, 50u);
  EXPECT_GT(bent, 1e-3);
  EXPECT_LE(worst, 1e-6);
  EXPECT_LE(worst_bend, 3e-7);
}

/// Two needles, one of which bends, a ball beside them, a jaw that holds some of the particles around the first, and a
/// kept volume: in the order of the reference.
TEST_F(GlNeedle, ActsBetweenWhatHoldsAndWhatPresses) {
  const Model model = Insertion::gel(4);
  Scene scene(model);
  ToolPose first{.position = {0.0203, 0.0197, block_side + over_skin}},
      second{.position = {0.0123, 0.0141, block_side + over_skin}};
  scene.fix("z0");
  scene.add_tool("ball",
                 {.shape = Sphere{0.008}, .pose = {.position = {0.03, 0.03, block_side + 0.0085}}, .friction = 0.3});
  scene.add_tool("first", {.shape = thin_needle(), .pose = first, .friction = 0.5});
  scene.add_tool("jaw", {.shape = Box{{0.012, 0.004, 0.012}}, .pose = {.position = {0.02, 0.0442, 0.02}}});
  scene.add_tool("second", {.shape = bending(5e-3), .pose = second, .friction = 0.5});
  scene.constrain_volume();
  BesideReference pair(model, scene, damped(40.0));
  double worst = 0.0, worst_force = 0.0, largest_on_ball = 0.0;
  for (int k = 1; k <= 24; ++k) {
    const double in = k <= 16 ? 1e-3 * k : 1e-3 * (32 - k);
    first.position.z() = second.position.z() = block_side + over_skin - in;
    second.position.x() += 1e-4;
    scene.tool("first").move_to(first);
    scene.tool("second").move_to(second);
    scene.tool("ball").move_to({.position = {0.03, 0.03 - 5e-5 * k, block_side + 0.0085 - 1.5e-4 * k}});
    if (k == 12) scene.tool("jaw").grasp(0.0145);  // nodes of holes among them
    if (k >= 12) scene.tool("jaw").move_to({.position = {0.02 + 1e-4 * (k - 12), 0.0442, 0.02}});
    worst = std::max(worst, pair.off_after(12));
    for (const char* tool : {"ball", "first", "jaw", "second"}) {
      const ToolForce a = pair.device->tool_force(tool), b = pair.reference->tool_force(tool);
      worst_force = std::max(worst_force, (a.mean_force - b.mean_force).norm());
      EXPECT_EQ(a.particles, b.particles) << tool << k;
    }
    largest_on_ball = std::max(largest_on_ball, pair.reference->tool_force("ball").mean_force.norm());
  }
  const State end = pair.device->read();
  EXPECT_TRUE(end.tools[1].needle.punctured && end.tools[3].needle.punctured);
  const std::vector<Index>& skin = end.tools[1].needle.hole.front().particles;
  EXPECT_TRUE(std::ranges::any_of(skin, [&](Index i) { return std::ranges::count(end.tools[2].held, i) > 0; }));
  EXPECT_GT(largest_on_ball, 0.02);
  std::printf("[ NEEDLES ] with tools and a volume: off by %.2g of the motion, forces by %.2g N\n", worst, worst_force);
  EXPECT_LE(worst, 2e-5);
  EXPECT_LE(worst_force, 5e-5);
}

/// A point of the exit has all its particles to one side, where weights are the hardest to get right: read() and
/// reset() promise sums within 1e-6.
TEST_F(GlNeedle, AStateAtAnObliqueExitCanBeGoneOnFrom) {
  const Model model = with_material(make_block({0.04, 0.04, 0.04}, 5, 5, 5), {10e3, 0.45, 1000.0});
  for (const double tilt : {0.55, 0.7, 0.85}) {
    const Needle needle{.length = 0.1, .radius = 0.6e-3, .puncture = 0.4, .cutting = 0.15, .spread = 0.012};
    ToolPose pose{.position = {0.022, 0.0197, 0.0403},
                  .orientation = Quaternion(Eigen::AngleAxisd(-tilt, Vec3::UnitY()))};
    Scene scene = Scene(model).fix("z0").add_tool("needle", {.shape = needle, .pose = pose, .friction = 0.5});
    const auto solver = make_solver("gl-compute", model, scene, {}, damped(40.0));
    bool through = false;
    double off = 0.0;
    for (int k = 0; k < 45; ++k) {
      pose.position -= 1e-3 * (pose.orientation * Vec3::UnitZ());
      scene.tool("needle").move_to(pose);
      ASSERT_TRUE(solver->step(12, 0.4 * solver->stable_step()).ok()) << tilt;
      const NeedleState state = solver->read().tools[0].needle;
      through = through || state.through;
      for (const NeedleNode& node : state.hole) {
        double sum = 0.0;
        for (const double weight : node.weights) sum += weight;
        off = std::max(off, std::abs(sum - 1.0));
      }
    }
    EXPECT_TRUE(through) << tilt;
    EXPECT_LE(off, 5e-7) << tilt;
    solver->reset(solver->read());
  }
}

/// Pushed through one body that rests on another: needles before contacts.
TEST_F(GlNeedle, ActsBeforeContacts) {
  const Model model = stacked(0.0004);
  Needle thin = thin_needle();
  thin.puncture = 0.06;
  thin.cutting = 0.03;
  thin.spread = 0.009;
  ToolPose pose{.position = {0.0123, 0.0131, 0.0209}};
  Scene scene = Scene(model).fix("low/z0").contacts({.friction = 0.3});
  scene.add_tool("needle", {.shape = thin, .pose = pose, .friction = 0.5});
  BesideReference pair(model, scene, damped(20.0));
  double worst = 0.0;
  for (int k = 0; k < 16; ++k) {
    pose.position.z() -= 1e-3;
    scene.tool("needle").move_to(pose);
    worst = std::max(worst, pair.off_after(12));
    EXPECT_EQ(pair.device->tool_force("needle").particles, pair.reference->tool_force("needle").particles) << k;
  }
  const State end = pair.device->read();
  EXPECT_TRUE(end.tools[0].needle.punctured);
  EXPECT_GT(end.tools[0].needle.hole.size(), 2u);
  std::printf("[ NEEDLES ] with contacts: off by %.2g of the motion\n", worst);
  EXPECT_LE(worst, 1e-5);
}

/// The programs of a needle that bends serve one that does not, also with what a change of the scene made anew.
TEST_F(GlNeedle, AStiffOneBesideOneThatBendsOutlivesAChangeOfTheScene) {
  const Model model = Insertion::gel(3);
  Scene scene = Scene(model).fix("z0");
  ToolPose stiff_pose{.position = {0.0203, 0.0197, block_side + over_skin}},
      pose{.position = {0.0103, 0.0297, block_side + over_skin}};
  scene.add_tool("stiff", {.shape = thin_needle(), .pose = stiff_pose, .friction = 0.5});
  scene.add_tool("bends", {.shape = bending(5e-3), .pose = pose, .friction = 0.5});
  BesideReference pair(model, scene, damped(40.0));
  for (int k = 0; k < 4; ++k) {
    stiff_pose.position.z() -= 2e-3;
    pose.position.z() -= 2e-3;
    scene.tool("stiff").move_to(stiff_pose);
    scene.tool("bends").move_to(pose);
    if (k == 2) scene.gravity({1, 0, 0});
    EXPECT_LE(pair.off_after(40), 1e-5) << k;
  }
  EXPECT_GT(pair.device->read().tools[0].needle.hole.size(), 1u);
}

/// Nothing to puncture: the shaft passes between the particles.
TEST_F(GlNeedle, MakesNoHoleInABodyWithoutASurface) {
  Model model = without_cells(Insertion::gel(3));
  model.materials.clear();
  Scene scene(model);
  ToolPose pose{.position = {0.0203, 0.0197, block_side + offset}};
  scene.add_tool("needle", {.shape = thin_needle(), .pose = pose, .friction = 0.5});
  SolverOptions options = damped(40.0);
  options.on_unstable = UnstableStep::allow;
  const auto tables =
      std::make_shared<const TopologyTextures>(build_topology(model, {.on_sparse = SparseParticle::free}));
  gl::DeviceSolver solver(GlBackend::compute, tables, scene, options);
  pose.position.z() -= 0.01;
  scene.tool("needle").move_to(pose);
  ASSERT_TRUE(solver.step(10, 1e-4).ok());
  const State state = solver.read();
  EXPECT_TRUE(state.tools[0].needle.hole.empty());
  for (const Vec3& v : state.velocity) EXPECT_EQ(v, Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace phymul::test
