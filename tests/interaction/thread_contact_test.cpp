// SPDX-License-Identifier: MIT
//
// Free threads that lie on tools and on tissue (Thread::touches).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/joined_particles.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double thread_step = 0.5e-3;  // s

double mass_of(const Thread& thread) {
  return thread.density * std::numbers::pi * thread.radius * thread.radius * thread.length;
}

Vec3 sum(const VecList& all) {
  Vec3 total = Vec3::Zero();
  for (const Vec3& one : all) total += one;
  return total;
}

/// A thread and tools, far from the one particle that is the body.
struct ThreadAlone {
  Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene{model};
  std::unique_ptr<Solver> solver;

  void start() { solver = loose_solver("reference", model, scene); }
  const ThreadState& state() const { return solver->thread_state("thread"); }
};

/// Falls flat on a floor and stays there: what carries it is its weight.
TEST(ThreadContact, LiesOnAFloorByItsWeight) {
  ThreadAlone body;
  const Thread thread{.length = 0.1, .damping = 5.0, .touches = true};
  body.scene.gravity({0, 0, -9.81});
  body.scene.add_tool("floor", {.shape = HalfSpace{}});
  body.scene.add_thread("thread", thread, {0, 0, 0.02}, {1, 0, 0});
  body.start();
  double lowest = 1.0;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(body.solver->step(1, thread_step).ok());
    for (const Vec3& x : body.state().position) lowest = std::min(lowest, x.z());
  }
  EXPECT_GT(lowest, thread.radius - 1e-6) << "at 0.6 m/s";
  for (const Vec3& x : body.state().position) EXPECT_NEAR(x.z(), thread.radius, 1e-6);
  const double weight = 9.81 * mass_of(thread);
  EXPECT_NEAR(sum(body.state().touch).z() / weight, 1.0, 1e-6);
  EXPECT_NEAR(body.solver->tool_force("floor").force.z() / weight, -1.0, 1e-6);
}

/// On a slope it stays up to the angle of friction, and slides down beyond it as a block does.
TEST(ThreadContact, SlidesDownASlopeByCoulombsLaw) {
  for (const double angle : {0.15, 0.5}) {
    SCOPED_TRACE(angle);
    ThreadAlone body;
    const Thread thread{.length = 0.03, .touches = true, .friction = 0.2};
    body.scene.gravity({9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)});
    body.scene.add_tool("floor", {.shape = HalfSpace{}});
    body.scene.add_thread("thread", thread, {0, 0, thread.radius}, {1, 0, 0});
    body.start();
    ASSERT_TRUE(body.solver->step(400, thread_step).ok());
    const double time = 400 * thread_step;
    const double pull = std::max(0.0, std::sin(angle) - thread.friction * std::cos(angle));
    EXPECT_NEAR(body.state().velocity.front().x(), 9.81 * pull * time, 0.002 * 9.81 * time);
    EXPECT_NEAR(body.state().velocity.back().x(), 9.81 * pull * time, 0.002 * 9.81 * time);
  }
}

/// A floor that glides takes it along, to its own speed.
TEST(ThreadContact, GoesWithTheFloorThatItSticksTo) {
  ThreadAlone body;
  const Thread thread{.length = 0.03, .touches = true, .friction = 0.2};
  body.scene.gravity({0, 0, -9.81});
  body.scene.add_tool("floor", {.shape = HalfSpace{}, .pose = {.velocity = {0.05, 0, 0}}});
  body.scene.add_thread("thread", thread, {0, 0, thread.radius}, {1, 0, 0});
  body.start();
  ASSERT_TRUE(body.solver->step(200, thread_step).ok());
  for (const Vec3& v : body.state().velocity) EXPECT_LT((v - Vec3(0.05, 0, 0)).norm(), 1e-4);
}

/// A floor that was put over it lets it out slowly.
TEST(ThreadContact, ComesOutOfAToolWithoutBeingFlung) {
  ThreadAlone body;
  const Thread thread{.length = 0.03, .touches = true};
  body.scene.add_tool("floor", {.shape = HalfSpace{}});
  body.scene.add_thread("thread", thread, {0, 0, -1e-3}, {1, 0, 0});
  body.start();
  double fastest = 0.0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(body.solver->step(1, thread_step).ok());
    for (const Vec3& v : body.state().velocity) fastest = std::max(fastest, v.norm());
  }
  EXPECT_LT(fastest, 0.3);
  for (const Vec3& x : body.state().position) EXPECT_GT(x.z(), thread.radius - 1e-6);
}

/// Drawn over a round bar with half a turn: T2 = T1 exp(mu theta).
TEST(ThreadContact, DrawnOverABarItsTensionsAreEulersAndEytelweins) {
  for (const double friction : {0.1, 0.4}) {
    SCOPED_TRACE(friction);
    ThreadAlone body;
    constexpr double radius = 0.01, light = 0.1;  // m, N
    const Thread thread{.length = 0.2,
                        .bending_stiffness = 1e-9,
                        .segment = 1e-3,
                        .damping = 20,
                        .touches = true,
                        .friction = friction};
    body.scene.add_tool(
        "bar", {.shape = Capsule{radius, 0.1},
                .pose = {.position = {0, 0.05, 0}, .orientation = Quaternion(std::sqrt(0.5), std::sqrt(0.5), 0, 0)}});
    const ThreadHandle handle = body.scene.add_thread("thread", thread, {-0.1, 0, radius + thread.radius}, {1, 0, 0});
    body.start();
    // Laid over the bar, then drawn to one side against a force on the other.
    const Index last = handle.thread().nodes() - 1;
    const double out = radius + thread.radius, down = 0.5 * thread.length - 0.5 * std::numbers::pi * out;
    handle.hold(0, {-out, 0, -down});
    handle.hold(last, {out, 0, -down});
    ASSERT_TRUE(body.solver->step(2000, thread_step).ok());
    handle.release(0);
    handle.pull(ThreadTip::first, {0, 0, -light});
    handle.hold(last, {out, 0, -down - 0.02});
    ASSERT_TRUE(body.solver->step(2000, thread_step).ok());
    const double ratio = body.state().tension.back() / body.state().tension.front();
    std::printf("[ TENSION  ] friction %.1f: %.4f, exact %.4f\n", friction, ratio,
                std::exp(friction * std::numbers::pi));
    EXPECT_NEAR(ratio / std::exp(friction * std::numbers::pi), 1.0, 0.02);
    EXPECT_NEAR(body.solver->tool_force("bar").force.z(), -light - body.state().tension.back(), 0.02 * light);
    for (const Vec3& x : body.state().position) {
      const double away = std::hypot(x.x(), x.z()) - radius - thread.radius;
      EXPECT_GT(away, -2e-5) << "of a chord's " << std::pow(thread.segment, 2) / 8.0 / radius;
    }
  }
}

/// A bar of 2 mm goes through where the thread is: up to twice its thickness in a step of 1 ms.
TEST(ThreadContact, AFastToolDoesNotPassThroughIt) {
  for (const double speed : {0.3, 1.0, 2.0}) {
    SCOPED_TRACE(speed);
    ThreadAlone body;
    const Thread thread{.length = 0.06, .segment = 1e-3, .damping = 10, .touches = true};
    body.scene.add_thread("thread", thread, {-0.03, 0, 0}, {1, 0, 0});
    const Quaternion along_y(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
    body.scene.add_tool("bar", {.shape = Capsule{1e-3, 0.04}, .pose = {{0, 0.02, 0.02}, along_y}});
    body.start();
    const double dt = 1e-3;
    const int steps = static_cast<int>(0.04 / speed / dt);
    body.scene.tool("bar").move_to({{0, 0.02, -0.02}, along_y});
    ASSERT_TRUE(body.solver->step(steps, dt).ok());
    double lowest = 1.0;
    for (const Vec3& x : body.state().position) {
      if (std::abs(x.x()) < 2e-3) lowest = std::min(lowest, x.z());
      EXPECT_FALSE(std::abs(x.x()) < 0.5e-3 && x.z() > -0.02 + 0.5e-3) << "above the bar";
    }
    EXPECT_LT(lowest, -0.02) << "the bar has taken it along";
  }
}

using ThreadOnTissue = WithTools;
PHYMUL_ON_EVERY_BACKEND(ThreadOnTissue);

/// Over 1/2: the place is within the surface (A. Van Oosterom, J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983)
/// 125-126).
double turns_around(const Vec3& place, const VecList& x, std::span<const std::array<Index, 3>> triangles) {
  double angle = 0.0;
  for (const auto& [i, j, k] : triangles) {
    const Vec3 a = x[i] - place, b = x[j] - place, c = x[k] - place;
    const double below =
        a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), below);
  }
  return angle / (4.0 * std::numbers::pi);
}

/// Its ends are drawn down on both sides of a block that floats, over the edges: all that they give is in both, and no
/// node gets in.
TEST_P(ThreadOnTissue, KeepsTheMomentumAndStaysOutside) {
  const Model model = soft_block({0.03, 0.03, 0.015}, 6, 6, 3);
  const std::vector<std::array<Index, 3>> surface = surface_triangles(model);
  Scene scene(model);
  const Thread thread{.length = 0.05, .segment = 1e-3, .damping = 0.0, .touches = true, .friction = 0.3};
  const ThreadHandle handle = scene.add_thread("thread", thread, {-0.01, 0.0143, 0.016}, {1, 0.02, 0});
  const Vec3 pull(0, 0.0005, -0.003);
  handle.pull(ThreadTip::first, pull);
  handle.pull(ThreadTip::last, pull);
  const auto solver = make(model, scene);
  const double dt = 0.4 * solver->stable_step();
  const double node = mass_of(thread) / (static_cast<double>(handle.thread().nodes()) - 1.0);
  for (int k = 1; k <= 10; ++k) {
    const auto steps = static_cast<int>(0.004 / dt);
    ASSERT_TRUE(solver->step(steps, dt).ok());
    const ThreadState& state = solver->thread_state("thread");
    Vec3 left = solver->momentum().linear - 2.0 * pull * dt * steps * k;
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      left += (i == 0 || i + 1 == state.position.size() ? 0.5 : 1.0) * node * state.velocity[i];
    }
    EXPECT_LE(left.norm(), (GetParam() == "reference" ? 1e-12 : 1e-5) * pull.norm() * dt * steps * k) << k;
    const VecList x = solver->read().position;
    for (const Vec3& at : state.position) EXPECT_LT(turns_around(at, x, surface), 0.5) << k;
  }
  EXPECT_GT(solver->momentum().linear.norm(), 0.9 * 2.0 * pull.norm() * 0.04) << "the body has most of it";
  EXPECT_FALSE(solver->thread_state("thread").touch.empty());
}

/// A little below the surface at the start: it comes out through the side that it is near.
TEST_P(ThreadOnTissue, ComesOutOfTheSurface) {
  const Model model = soft_block({0.03, 0.03, 0.015}, 6, 6, 3);
  Scene scene = Scene(model).fix("z0");
  const Thread thread{.length = 0.02, .segment = 1e-3, .damping = 20, .touches = true};
  scene.add_thread("thread", thread, {0.005, 0.0143, 0.015 - 2e-4}, {1, 0.02, 0});
  const auto solver = make(model, scene, {.damping = 20.0});
  ASSERT_TRUE(solver->step(static_cast<int>(0.05 / (0.4 * solver->stable_step())), 0.4 * solver->stable_step()).ok());
  for (const Vec3& x : solver->thread_state("thread").position) EXPECT_GT(x.z(), 0.015 + 0.5 * thread.radius);
}

/// Where it was never outside, no side is the one that it came in by: it is left where it is, and so is the tissue.
TEST_P(ThreadOnTissue, DeepInTissueItPushesNothing) {
  const Model model = soft_block({0.03, 0.03, 0.015}, 6, 6, 3);
  Simulation sim(model, {.backend = GetParam()});
  sim.scene().add_thread("thread", {.length = 0.02, .segment = 1e-3, .touches = true}, {0.005, 0.0143, 0.0075},
                         {1, 0, 0});
  ASSERT_TRUE(sim.advance(2e-3).ok());
  EXPECT_LT(sim.max_displacement(), 1e-9);
  for (const Vec3& v : sim.state().velocity) ASSERT_LT(v.norm(), 1e-9);
}

/// A coarse block comes from afar and hits a thread as heavy as it is, many nodes at once. None of the blows is counted
/// for more than one node, so that no energy appears.
TEST_P(ThreadOnTissue, IsHitByABodyThatComes) {
  const Model model = soft_block({0.03, 0.03, 0.015}, 2, 2, 1);
  const std::vector<std::array<Index, 3>> surface = surface_triangles(model);
  Scene scene(model);
  const Thread thread{.length = 0.024, .density = 5e6, .segment = 2e-4, .touches = true, .friction = 0.3};
  const ThreadHandle handle = scene.add_thread("thread", thread, {0.003, 0.0143, 0.030}, {1, 0.02, 0});
  const auto solver = make(model, scene);
  State state = solver->read();
  for (Vec3& v : state.velocity) v = {0, 0, 0.3};
  solver->reset(state);
  const double dt = 0.2 * solver->stable_step(), before = solver->energy().kinetic;
  const double node = mass_of(thread) / (static_cast<double>(handle.thread().nodes()) - 1.0);
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(solver->step(static_cast<int>(0.005 / dt), dt).ok());
    const ThreadState& own = solver->thread_state("thread");
    double energy = solver->energy().kinetic + solver->energy().elastic;
    for (const Vec3& v : own.velocity) energy += 0.5 * node * v.squaredNorm();
    EXPECT_LT(energy, 1.02 * before) << k;
    const VecList x = solver->read().position;
    for (const Vec3& at : own.position) EXPECT_LT(turns_around(at, x, surface), 0.5) << k;
  }
  double speed = 0.0;
  for (const Vec3& v : solver->thread_state("thread").velocity) speed = std::max(speed, v.z());
  EXPECT_GT(speed, 0.1) << "it was hit";
}

/// What it lies on is part of the state.
TEST_P(ThreadOnTissue, GoesOnFromASnapshot) {
  const Model model = soft_block({0.03, 0.03, 0.015}, 6, 6, 3);
  Scene scene = Scene(model).fix("z0").gravity({0, 0, -9.81});
  const Thread thread{.length = 0.04, .segment = 1e-3, .touches = true, .friction = 0.3};
  const ThreadHandle handle = scene.add_thread("thread", thread, {-0.005, 0.015, 0.016}, {1, 0.1, 0});
  handle.pull(ThreadTip::last, {1e-5, 0, -1e-5});
  const auto solver = make(model, scene);
  const double dt = 0.4 * solver->stable_step();
  ASSERT_TRUE(solver->step(static_cast<int>(0.03 / dt), dt).ok());
  const Snapshot kept = solver->snapshot();
  ASSERT_FALSE(solver->thread_state("thread").touch.empty());
  ASSERT_TRUE(solver->step(100, dt).ok());
  const State once = solver->read();
  solver->restore(kept);
  ASSERT_TRUE(solver->step(100, dt).ok());
  EXPECT_EQ(solver->read(), once);
}

}  // namespace
}  // namespace phymul::test
