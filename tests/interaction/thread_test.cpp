// SPDX-License-Identifier: MIT
//
// Free threads against closed forms: a heavy elastica, a buckled one, tension, momentum, energy, breaking.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/joined_particles.h"
#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double thread_dt = 0.5e-3;  // s

/// Polypropylene of 0.3 mm, 101 nodes; bending reaches the middle of the first segment, so it is longer by half of it.
Thread reference_thread(double length, double damping) {
  const double whole = length / (1.0 - 0.5 / 100.0);
  return {.length = whole, .segment = whole / 100.0, .damping = damping};
}

/// Clamped along x at the origin's side; the body is a particle far away.
struct Clamped {
  Clamped(double clamped_length, double damping, const Vec3& gravity) : length(clamped_length) {
    scene.gravity(gravity);
    const Thread constants = reference_thread(length, damping);
    thread.emplace(scene.add_thread("thread", constants, Vec3(-0.5 * constants.segment, 0, 0), {1, 0, 0}));
    for (const Index node : {0, 1}) thread->hold(node, Vec3((node - 0.5) * constants.segment, 0, 0));
    solver = loose_solver("reference", model, scene);
  }
  Vec3 tip() const { return solver->thread_state("thread").position.back() / length; }
  void run(double seconds) {
    EXPECT_TRUE(solver->step(static_cast<int>(std::lround(seconds / thread_dt)), thread_dt).ok());
  }

  double length;
  Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene{model};
  std::optional<ThreadHandle> thread;
  std::unique_ptr<Solver> solver;
};

TEST(Thread, ItsConstantsAreThoseOfARoundSection) {
  EXPECT_NEAR(axial_stiffness({}), 141.4, 0.05);
  EXPECT_NEAR(bending_stiffness({}), 7.95e-7, 1e-9);
  EXPECT_EQ(bending_stiffness({.bending_stiffness = 1e-8}), 1e-8);
}

TEST(Thread, BendsUnderItsWeightAsAnElastica) {
  Clamped body(0.15, 30.0, {0, 0, -9.81});
  body.run(2.0);
  EXPECT_NEAR(-body.tip().z(), 0.31167, 1e-3);
}

TEST(Thread, BucklesAsAnElastica) {
  Clamped body(0.15, 30.0, Vec3::Zero());
  const double critical = std::pow(std::numbers::pi / 0.15, 2) / 4.0 * bending_stiffness({});
  body.thread->pull(ThreadTip::last, {-1.15174 * critical, 0, 0.2 * critical});
  body.run(0.5);
  body.thread->pull(ThreadTip::last, {-1.15174 * critical, 0, 0});
  body.run(8.0);
  EXPECT_NEAR(body.tip().z(), 0.5932, 1e-3);
  EXPECT_NEAR(body.tip().x(), 0.7410, 1e-3);
}

TEST(Thread, HangsWithTheTensionOfItsLoad) {
  Clamped body(0.3, 60.0, {0, 0, -9.81});
  body.thread->release(1);
  body.thread->hold(0, Vec3::Zero());
  body.thread->pull(ThreadTip::last, {0, 0, -0.05 * 9.81});
  body.run(4.0);
  const ThreadState& state = body.solver->thread_state(*body.thread);
  const Thread& constants = body.thread->thread().thread;
  const double section = std::numbers::pi * std::pow(constants.radius, 2);
  for (const std::size_t k : {0, 50, 99}) {
    const double below = constants.density * section * constants.segment * (99.5 - static_cast<double>(k));
    const double exact = 9.81 * (0.05 + below);
    EXPECT_NEAR(state.tension[k] / exact, 1.0, 1e-6) << k;
    const double stretch = (state.position[k + 1] - state.position[k]).norm() / state.rest_length[k] - 1.0;
    EXPECT_NEAR(stretch * axial_stiffness(constants) / exact, 1.0, 1e-6) << k;
  }
}

double energy_of(const ThreadState& state, const Thread& constants, double gravity) {
  const double l = state.rest_length.front(),
               mass = constants.density * std::numbers::pi * std::pow(constants.radius, 2) * l;
  double energy = 0.0;
  const std::size_t n = state.position.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double own = i == 0 || i + 1 == n ? 0.5 * mass : mass;
    energy += own * (0.5 * state.velocity[i].squaredNorm() + gravity * state.position[i].z());
    if (i + 1 == n) continue;
    const double longer = (state.position[i + 1] - state.position[i]).norm() - l;
    energy += 0.5 * axial_stiffness(constants) / l * longer * longer;
    if (i == 0) continue;
    const Vec3 bend = state.position[i + 1] - 2.0 * state.position[i] + state.position[i - 1];
    energy += 0.5 * bending_stiffness(constants) / (l * l * l) * bend.squaredNorm();
  }
  return energy;
}

TEST(Thread, WhipsWithoutGainingEnergy) {
  for (const double dt : {1e-4, 5e-4, 1e-3}) {
    for (const double young : {2e7, 3e9}) {
      Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
      Scene scene(model);
      scene.gravity({0, 0, -9.81});
      const Thread constants{.length = 0.3, .young = young, .segment = 0.3 / 100};
      const ThreadHandle thread = scene.add_thread(constants, Vec3::Zero(), {1, 0, 0});
      thread.hold(0, Vec3::Zero());
      const auto solver = loose_solver("reference", model, scene);
      const double weight = constants.density * std::numbers::pi * std::pow(constants.radius, 2) * 0.3 * 9.81;
      double largest = 0.0, lowest = 0.0;
      for (int k = 0; k < 1.0 / dt; ++k) {
        ASSERT_TRUE(solver->step(1, dt).ok());
        const double energy = energy_of(solver->thread_state(thread), constants, 9.81) / (weight * 0.15);
        largest = std::max(largest, energy);
        lowest = std::min(lowest, solver->thread_state(thread).position.back().z());
      }
      EXPECT_LT(largest, 1e-4) << dt << ' ' << young;
      EXPECT_LT(lowest, -0.2) << "it fell";
    }
  }
}

/// Ten thousand times its weight: one iteration of Newton's method a step flings it away, faster and faster.
TEST(Thread, AForceAtItsTipDoesNotFlingItAway) {
  for (const double segment : {1e-3, 3e-3}) {
    for (const double force : {0.1, 10.0}) {
      const Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
      Scene scene(model);
      const ThreadHandle thread =
          scene.add_thread({.length = 0.2, .bending_stiffness = 1e-9, .segment = segment}, Vec3(-0.1, 0, 0), {1, 0, 0});
      thread.pull(ThreadTip::first, {0, 0, -force});
      thread.hold(thread.thread().nodes() - 1, {0.1, 0, 0});
      const auto solver = loose_solver("reference", model, scene);
      ASSERT_TRUE(solver->step(2000, thread_dt).ok());
      const ThreadState& state = solver->thread_state(thread);
      EXPECT_NEAR(state.tension.front() / force, 1.0, 1e-6) << segment << ' ' << force;
      const double longer = 0.2 * (1.0 + force / axial_stiffness({}));
      EXPECT_LT((state.position.front() - Vec3(0.1, 0, -longer)).norm(), 1e-6) << segment << ' ' << force;
    }
  }
}

/// Slices of a call, which depend on the time that it takes, would make it jump.
TEST(Thread, WhatHoldsItGoesEvenlyWithProgress) {
  State end;
  for (const bool progress : {false, true}) {
    const Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
    Scene scene(model);
    const ThreadHandle thread = scene.add_thread({.length = 0.1}, Vec3::Zero(), {1, 0, 0});
    thread.hold(0, {0.02, 0.03, 0});
    SolverOptions options;
    if (progress) options.progress = [](const StepProgress&) { return true; };
    const auto solver = loose_solver("reference", model, scene, options);
    ASSERT_TRUE(solver->step(100, thread_dt).ok());
    if (progress) {
      EXPECT_EQ(solver->read(), end);
    }
    end = solver->read();
  }
}

class ThreadIn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(ThreadIn);

/// Two beads at the ends of a thread that is not yet taut, moving apart.
TEST_P(ThreadIn, JoinsTwoBodiesAndKeepsTheirMomentum) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.1, 0, 0)}, 1e-3);
  Scene scene(model);
  const Thread constants{.length = 0.1, .segment = 0.01};
  const ThreadHandle thread = scene.add_thread(constants, Vec3::Zero(), {1, 0, 0});
  thread.join(ThreadTip::first, at_particle(0));
  thread.join(ThreadTip::last, at_particle(1));
  const auto solver = loose_solver(GetParam(), model, scene);
  State start = rest_state(model);
  start.velocity[0] = Vec3(-0.1, 0.02, 0.01);
  start.velocity[1] = Vec3(0.1, 0.05, -0.03);
  solver->reset(start);
  const double node = constants.density * std::numbers::pi * std::pow(constants.radius, 2) * constants.segment;
  const auto momentum = [&] {
    Vec3 sum = solver->momentum().linear;
    const VecList& v = solver->thread_state(thread).velocity;
    for (std::size_t i = 0; i < v.size(); ++i) sum += (i == 0 || i + 1 == v.size() ? 0.5 : 1.0) * node * v[i];
    return sum;
  };
  const Vec3 before = momentum();
  ASSERT_TRUE(solver->step(200, thread_dt).ok());
  const State end = solver->read();
  EXPECT_LT((end.position[1] - end.position[0]).norm(), 0.101);
  EXPECT_LT((end.velocity[1] - end.velocity[0]).dot(Vec3(1, 0, 0)), 0.02) << "the thread was never taut";
  EXPECT_LT((momentum() - before).norm(), (GetParam() == "reference" ? 1e-12 : 2e-5) * 1e-3 * 0.2);
  const ThreadState& state = solver->thread_state(thread);
  EXPECT_LT((state.position.front() - end.position[0]).norm(), 1e-7);
  EXPECT_LT((state.position.back() - end.position[1]).norm(), 1e-7);
}

TEST_P(ThreadIn, HangsFromATool) {
  const Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene(model);
  scene.gravity({0, 0, -9.81}).fix(std::vector<Index>{0});
  scene.add_tool("hand", {.shape = Sphere{0.01}, .pose = {.position = {0, 0, 0.1}}});
  const ThreadHandle thread = scene.add_thread({.length = 0.1, .damping = 20.0}, {0.01, 0, 0.1}, {0, 0, -1});
  thread.join(ThreadTip::first, at_tool("hand", {0.01, 0, 0}));
  const auto solver = loose_solver(GetParam(), model, scene);
  scene.tool("hand").move_to({.position = {0.05, 0, 0.1}});
  ASSERT_TRUE(solver->step(4000, thread_dt).ok());
  ASSERT_TRUE(solver->step(2000, thread_dt).ok());
  const double weight = 920.0 * std::numbers::pi * std::pow(0.15e-3, 2) * 0.1 * 9.81,
               own = 0.5 / (thread.thread().nodes() - 1);
  EXPECT_NEAR(solver->tool_force("hand").force.z() / weight, -1.0 + own, 1e-6);  // half a segment is the tip's
  EXPECT_NEAR(solver->tool_force("hand").torque.y() / weight, (1.0 - own) * 0.01, 1e-6);
  EXPECT_LT((solver->thread_state(thread).position.front() - Vec3(0.06, 0, 0.1)).norm(), 1e-12);
  EXPECT_EQ(solver->thread_state(thread).force[0], solver->tool_force("hand").force);
}

/// Threads do not move particles that a tool holds, and the tool feels the force of the threads.
TEST_P(ThreadIn, PullAtAToolThroughWhatItHolds) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.05, 0, 0)}, 1e-4);
  Scene scene(model);
  scene.fix(std::vector<Index>{1});
  const ToolHandle hand = scene.add_tool("hand", {.shape = Sphere{2e-3}});
  const ThreadHandle sewn = scene.sew("sewn", {}, std::vector<Anchor>{at_particle(0), at_particle(1)});
  const ThreadHandle free = scene.add_thread("free", {.length = 0.02}, {0, 0, 0}, {-1, 0, 0});
  free.join(ThreadTip::first, at_particle(0));
  free.pull(ThreadTip::last, {-0.3, 0, 0});
  const auto solver = loose_solver(GetParam(), model, scene);
  hand.grasp(1e-3);
  ASSERT_TRUE(solver->step(1, thread_dt).ok());
  hand.move_to({.position = {-1e-3, 0, 0}});
  ASSERT_TRUE(solver->step(400, thread_dt).ok());
  EXPECT_LT((solver->read().position[0] - Vec3(-1e-3, 0, 0)).norm(), 1e-8);
  const double tension = axial_stiffness({}) * 1e-3 / 0.05;
  EXPECT_NEAR(solver->thread_state(sewn).tension[1] / tension, 1.0, 1e-5);
  EXPECT_NEAR(solver->tool_force("hand").force.x(), tension - 0.3, 1e-4 * tension);
  EXPECT_EQ(solver->tool_force("hand").particles, 1);
  hand.release();
  ASSERT_TRUE(solver->step(1, thread_dt).ok());
  EXPECT_LT(solver->thread_state(sewn).tension[1], 0.5 * tension);  // it takes the particle along
}

TEST(Thread, ANodeGoesWhereItIsHeldDuringOneCall) {
  Clamped body(0.1, 0.0, Vec3::Zero());
  body.thread->hold(50, body.solver->thread_state("thread").position[50] + Vec3(0, 0, 0.01));
  ASSERT_TRUE(body.solver->step(100, thread_dt).ok());
  const ThreadState& state = body.solver->thread_state("thread");
  EXPECT_NEAR(state.position[50].z(), 0.01, 1e-15);
  EXPECT_NEAR(state.velocity[50].z(), 0.01 / (100 * thread_dt), 1e-9);
  body.run(0.01);
  EXPECT_NEAR(body.solver->thread_state("thread").position[50].z(), 0.01, 1e-15);
  body.thread->release(50);
  body.run(0.5);
  EXPECT_GT(std::abs(body.solver->thread_state("thread").position[50].z() - 0.01), 1e-4);
}

TEST(Thread, BreaksWhereItsTensionIsTooLarge) {
  Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene(model);
  const ThreadHandle thread =
      scene.add_thread({.length = 0.1, .segment = 0.01, .breaking_force = 2.0}, Vec3::Zero(), {1, 0, 0});
  thread.join(ThreadTip::first, at_world(Vec3::Zero()));
  const auto solver = loose_solver("reference", model, scene);
  for (const double force : {1.9, 2.1}) {
    thread.pull(ThreadTip::last, {force, 0, 0});
    for (int k = 0; k < 2000; ++k) ASSERT_TRUE(solver->step(1, thread_dt).ok());
    const std::vector<std::uint8_t>& broken = solver->thread_state(thread).broken;
    EXPECT_EQ(std::ranges::count(broken, 1) > 0, force > 2.0) << force;
  }
  thread.pull(ThreadTip::last, Vec3::Zero());
  ASSERT_TRUE(solver->step(100, thread_dt).ok());
  EXPECT_TRUE(solver->thread_state(thread).position.back().allFinite());
  EXPECT_GT(solver->thread_state(thread).position.back().x(), 0.2) << "the part that broke off flies";
}

/// Then nothing pulls the rest: of segments under one tension the others stay whole.
TEST(Thread, BreaksInOnePlace) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.01, 0, 0), Vec3(0.02, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.fix(every_particle(model));
  const ThreadHandle free =
      scene.add_thread({.length = 0.1, .segment = 0.01, .breaking_force = 2.0}, Vec3::Zero(), {1, 0, 0});
  free.hold(0, Vec3::Zero());
  free.hold(10, {0.102, 0, 0});
  const ThreadHandle sewn = scene.sew("sewn", {.friction = 0.0, .breaking_force = 2.0},
                                      std::vector<Anchor>{at_particle(0), at_particle(1), at_particle(2)});
  const auto solver = loose_solver("reference", model, scene);
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) sewn.join(tip, at_world({-0.01, 0, 0}));
  ASSERT_TRUE(solver->step(1, thread_dt).ok());
  sewn.join(ThreadTip::last, at_world({-0.012, 0, 0}));
  ASSERT_TRUE(solver->step(400, thread_dt).ok());
  for (const ThreadHandle& thread : {free, sewn}) {
    const ThreadState& state = solver->thread_state(thread);
    EXPECT_EQ(std::ranges::count(state.broken, 1), 1) << state.name;
    for (const double tension : state.tension) EXPECT_LT(tension, 2.0) << state.name;
  }
}

TEST(Thread, KeepsAutoOnTheProcessor) {
  const std::vector<std::string> names = backend_names();
  if (std::ranges::find(names, "gl") == names.end()) GTEST_SKIP() << "built without GL: \"auto\" has no choice";
  Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene(model);
  scene.add_thread({}, Vec3::Zero(), {1, 0, 0});
  EXPECT_NE(loose_solver("auto", model, scene)->backend_reason().find("the scene has threads"), std::string_view::npos);
}

TEST(Thread, RefusesWhatItCannotBe) {
  Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene(model);
  const double nan = std::nan("");
  const auto add = [&](const Thread& thread, const Vec3& start = Vec3::Zero(), const Vec3& direction = {1, 0, 0}) {
    return [=, &scene] { scene.add_thread("t", thread, start, direction); };
  };
  EXPECT_EQ(message_of(add({.length = -1.0})), "thread \"t\": expected a length (m) above 0, got -1");
  for (const Thread& bad :
       {Thread{.length = nan}, Thread{.radius = infinite}, Thread{.young = 0.0}, Thread{.bending_stiffness = nan},
        Thread{.density = nan}, Thread{.segment = -1e-3}, Thread{.damping = nan}, Thread{.friction = -0.1},
        Thread{.channel_friction = nan}, Thread{.breaking_force = 0.0}, Thread{.passage_limit = nan},
        Thread{.throw_holding = infinite}, Thread{.segment = 1e-9}, Thread{.length = 1.0, .segment = 1e-5}}) {
    EXPECT_TRUE(refuses(add(bad), "thread \"t\": expected a"));
  }
  EXPECT_TRUE(refuses(add({}, {nan, 0, 0}), "expected a finite start"));
  EXPECT_TRUE(refuses(add({}, {0, 0, 0}, {0, 0, 0}), "expected a direction whose length is not 0"));
  EXPECT_TRUE(scene.threads().empty());
  add({.length = 0.99999, .segment = 1e-5})();
  EXPECT_EQ(scene.thread("t").thread().nodes(), 100000);
  scene.remove_thread("t");
  const ThreadHandle thread = scene.add_thread("t", {.length = 0.03}, Vec3::Zero(), {2, 0, 0});
  EXPECT_TRUE(refuses(add({}), "there is one of that name"));
  EXPECT_TRUE(refuses([&] { thread.hold(11, Vec3::Zero()); }, "thread \"t\": expected nodes from 0 to 10, got 11"));
  EXPECT_TRUE(refuses([&] { thread.pull(ThreadTip::last, {nan, 0, 0}); }, "expected a finite force (N)"));
  EXPECT_TRUE(refuses([&] { thread.fix(ThreadTip::last); }, "expected a sewn thread"));
  EXPECT_TRUE(refuses([&] { thread.join(ThreadTip::last, at_tool("x")); }, "no tool \"x\""));
  scene.add_tool("hand", Tool{.shape = Sphere{0.01}});
  thread.join(ThreadTip::last, at_tool("hand"));
  EXPECT_TRUE(refuses([&] { scene.remove_tool("hand"); }, "the thread \"t\" is joined to it"));
  scene.remove_thread("t");
  EXPECT_TRUE(refuses([&] { thread.release(0); }, "no longer has the thread"));
}

}  // namespace
}  // namespace phymul::test
