// SPDX-License-Identifier: MIT
//
// Free threads that touch themselves and each other (Thread::touches).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "support/allocation_count.h"
#include "support/joined_particles.h"

namespace phymul::test {
namespace {

constexpr double crossing_step = 0.5e-3;  // s

/// Threads alone, far from the one particle that is the body.
struct ThreadsAlone {
  Model model = loose_particles({Vec3(9, 9, 9)}, 1.0);
  Scene scene{model};
  std::unique_ptr<Solver> solver;

  void start() { solver = loose_solver("reference", model, scene); }
  const ThreadState& state(const std::string& name) const { return solver->thread_state(name); }
  void throw_at(const std::string& name, const Vec3& velocity) {
    State state = solver->read();
    for (ThreadState& thread : state.threads) {
      if (thread.name == name) thread.velocity.assign(thread.velocity.size(), velocity);
    }
    solver->reset(state);
  }
};

struct ThreadMotion {
  Vec3 momentum{0, 0, 0};
  double energy = 0.0;  // kinetic, of stretching and bending
};

void add_motion(const Thread& thread, const ThreadState& state, ThreadMotion& total) {
  const VecList &x = state.position, &v = state.velocity;
  const double length = state.rest_length.front();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool is_tip = i == 0 || i + 1 == x.size();
    const double mass = (is_tip ? 0.5 : 1.0) * thread.density * std::numbers::pi * std::pow(thread.radius, 2) * length;
    total.momentum += mass * v[i];
    total.energy += 0.5 * mass * v[i].squaredNorm();
    if (is_tip) continue;
    const Vec3 bend = x[i + 1] - 2.0 * x[i] + x[i - 1];
    total.energy += 0.5 * bending_stiffness(thread) * bend.squaredNorm() / (length * length * length);
  }
  for (const double tension : state.tension) total.energy += 0.5 * tension * tension * length / axial_stiffness(thread);
}

Vec3 touch_sum(const VecList& all) {
  return std::accumulate(all.begin(), all.end(), Vec3(0, 0, 0));
}

/// m: from places of one to the other. Of a thread with itself: of segments that are `skipped` or more apart along it.
double least_apart(const VecList& x, const VecList& y, std::size_t skipped = 0) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p + 1 < x.size(); ++p) {
    for (std::size_t q = skipped > 0 ? p + skipped : 0; q + 1 < y.size(); ++q) {
      const Vec3 one = x[p + 1] - x[p], other = y[q + 1] - y[q];
      if ((x[p] - y[q]).norm() > one.norm() + other.norm() + 1e-3) continue;
      for (int k = 0; k <= 200; ++k) {
        const Vec3 off = x[p] + 5e-3 * k * one - y[q];
        least = std::min(least, (off - std::clamp(off.dot(other) / other.squaredNorm(), 0.0, 1.0) * other).norm());
      }
    }
  }
  return least;
}

/// One is thrown on the other at 1 m/s, 0.5 mm a step, at any angle and place: it does not pass through, what it gives
/// the other has, and no energy appears.
TEST(ThreadCrossing, DoesNotPassThroughAnotherAndKeepsTheMomentum) {
  for (const double angle : {0.5 * std::numbers::pi, 0.7, 0.1, 0.0}) {
    for (const double off : {0.0, 1.5e-3, 0.7e-3}) {
      for (const double speed : {1.0, 3.0}) {
        SCOPED_TRACE(std::to_string(angle) + ", " + std::to_string(off) + ", " + std::to_string(speed));
        ThreadsAlone body;
        const Thread thread{.length = 0.03, .touches = true, .friction = 0.3};
        const Vec3 direction(std::cos(angle), std::sin(angle), 0);
        body.scene.add_thread("lower", thread, {-0.015, 0, 0}, {1, 0, 0});
        body.scene.add_thread("upper", thread, Vec3(off, 0.1 * off, 0.97e-3) - 0.015 * direction, direction);
        body.start();
        body.throw_at("upper", {0, 0, -speed});
        ThreadMotion before;
        for (const char* const name : {"lower", "upper"}) add_motion(thread, body.state(name), before);
        double nearest = 1.0;
        for (int k = 0; k < 60; ++k) {
          ASSERT_TRUE(body.solver->step(1, crossing_step).ok());
          ThreadMotion now;
          for (const char* const name : {"lower", "upper"}) add_motion(thread, body.state(name), now);
          ASSERT_LT((now.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm()) << k;
          ASSERT_LT(now.energy, (1.0 + 1e-9) * before.energy) << k;
          nearest = std::min(nearest, least_apart(body.state("lower").position, body.state("upper").position));
        }
        ThreadMotion upper;
        add_motion(thread, body.state("upper"), upper);
        EXPECT_GT(nearest, (speed > 1.0 ? 0.9 : 0.98) * 2.0 * thread.radius);
        EXPECT_GT(upper.momentum.z() / before.momentum.z(), 0.1);
        EXPECT_LT(upper.momentum.z() / before.momentum.z(), 0.9) << "the lower one was hit";
      }
    }
  }
}

/// Held across another: what presses them together is what tensions and directions say, on both.
TEST(ThreadCrossing, TautOverAnotherItPressesByTensionsAndAngles) {
  ThreadsAlone body;
  const Thread thread{.length = 0.06, .bending_stiffness = 1e-10, .damping = 30, .touches = true};
  const Index last = 20;
  const ThreadHandle lower = body.scene.add_thread("lower", thread, {-0.03, 0, 0}, {1, 0, 0});
  const ThreadHandle upper = body.scene.add_thread("upper", thread, {0.0007, -0.03, 4e-4}, {0, 1, 0});
  for (const double end : {-1.0, 1.0}) {
    lower.hold(end < 0 ? 0 : last, {0.03 * end, 0, 0});
    upper.hold(end < 0 ? 0 : last, {0.0007, 0.03 * end, -5e-3});
  }
  body.start();
  ASSERT_TRUE(body.solver->step(1000, crossing_step).ok());
  const auto held = [](const ThreadState& state) {
    const VecList& x = state.position;
    const std::size_t n = x.size();
    return Vec3(state.tension.front() * (x[1] - x[0]).normalized() +
                state.tension.back() * (x[n - 2] - x[n - 1]).normalized());
  };
  const Vec3 by_lower = held(body.state("lower")), by_upper = held(body.state("upper"));
  const Vec3 on_lower = touch_sum(body.state("lower").touch), on_upper = touch_sum(body.state("upper").touch);
  std::printf("[ PRESS    ] %.4f N, tensions and angles %.4f and %.4f N\n", on_upper.z(), by_upper.z(), -by_lower.z());
  EXPECT_GT(on_upper.z(), 0.01);
  EXPECT_NEAR(on_upper.z() / by_upper.z(), 1.0, 0.01);
  EXPECT_NEAR(on_lower.z() / by_lower.z(), 1.0, 0.01);
  EXPECT_LT((on_lower + on_upper).norm(), 1e-12 * on_upper.norm());
  EXPECT_NEAR(least_apart(body.state("lower").position, body.state("upper").position) / (2.0 * thread.radius), 1.0,
              0.01);
}

/// On two threads that are held it stays up to a slope of mu, the geometric mean of both, and slides by Coulomb's law
/// beyond it.
TEST(ThreadCrossing, HoldsAndSlipsByCoulombsLaw) {
  constexpr double friction = 0.2;
  for (const double share : {0.9, 1.5}) {
    SCOPED_TRACE(share);
    ThreadsAlone body;
    const double angle = std::atan(share * friction);
    Thread thread{.length = 0.03, .touches = true, .friction = 0.4};
    body.scene.gravity({9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)});
    for (const double x : {-5e-3, 5e-3}) {
      const std::string name = x < 0 ? "left" : "right";
      const ThreadHandle rail = body.scene.add_thread(name, thread, {x, -0.015, 0}, {0, 1, 0});
      for (Index i = 0; i <= 10; ++i) rail.hold(i, {x, -0.015 + 3e-3 * i, 0});
    }
    thread.friction = 0.1;
    body.scene.add_thread("upper", thread, {-0.0142, 0.4e-3, 2.0 * thread.radius}, {1, 0, 0});
    body.start();
    const double time = 0.05;
    ASSERT_TRUE(body.solver->step(static_cast<int>(time / crossing_step), crossing_step).ok());
    const double speed = 9.81 * (std::sin(angle) - (share < 1.0 ? std::sin(angle) : friction * std::cos(angle))) * time;
    ThreadMotion upper;
    add_motion(thread, body.state("upper"), upper);
    const double mass = thread.density * std::numbers::pi * thread.radius * thread.radius * thread.length;
    std::printf("[ SLIP     ] at %.1f mu: %.4f m/s, Coulomb's %.4f m/s\n", share, upper.momentum.x() / mass, speed);
    EXPECT_NEAR(upper.momentum.x() / mass, speed, 0.01 * 9.81 * std::sin(angle) * time);
    EXPECT_GT(body.state("upper").position.front().z(), 0.9 * 2.0 * thread.radius);
  }
}

/// A thread that lies as a curve.
void lay_thread(ThreadsAlone& body, const std::string& name, const VecList& places) {
  State state = body.solver->read();
  for (ThreadState& thread : state.threads) {
    if (thread.name == name) thread.position = places;
  }
  body.solver->reset(state);
}

/// m: `count` places, `spacing` apart along a curve.
template <class Curve>
VecList laid_along(Curve curve, double from, std::size_t count, double spacing) {
  VecList places{curve(from)};
  for (double t = from; places.size() < count; t += 1e-5) {
    if ((curve(t) - places.back()).norm() >= spacing) places.push_back(curve(t));
  }
  return places;
}

/// An overhand knot is drawn together: it stays one.
TEST(ThreadCrossing, AnOverhandKnotDoesNotComeUndone) {
  ThreadsAlone body;
  const Thread thread{.length = 0.1, .bending_stiffness = 2e-9, .segment = 1e-3, .damping = 20, .touches = true};
  const ThreadHandle handle = body.scene.add_thread("thread", thread, {0, 0, 0}, {1, 0, 0});
  body.start();
  const auto knot = [](double t) {
    return Vec3(2e-3 * (t * t * t - 3.0 * t), 1.2e-3 * (t * t * t * t - 4.0 * t * t),
                2e-4 * (t * t * t * t * t - 10.0 * t));
  };
  lay_thread(body, "thread", laid_along(knot, -2.35, 101, 1e-3));
  const VecList start = body.state("thread").position;
  double nearest = 1.0;
  constexpr int calls = 40;
  for (int k = 1; k <= calls; ++k) {
    const double share = static_cast<double>(k) / calls;
    handle.hold(0, (1.0 - share) * start.front() + share * Vec3(-0.044, 0, 0));
    handle.hold(100, (1.0 - share) * start.back() + share * Vec3(0.044, 0, 0));
    ASSERT_TRUE(body.solver->step(10, crossing_step).ok());
    const VecList& places = body.state("thread").position;
    nearest = std::min(nearest, least_apart(places, places, 3));
  }
  std::printf("[ KNOT     ] nearest %.3f of two radii\n", nearest / (2.0 * thread.radius));
  EXPECT_GT(nearest, 0.8 * 2.0 * thread.radius);
  double pressed = 0.0;
  for (const Vec3& force : body.state("thread").touch) pressed = std::max(pressed, force.norm());
  EXPECT_GT(pressed, 1e-5) << "it holds itself";
  EXPECT_LT(touch_sum(body.state("thread").touch).norm(), 1e-12 * pressed);
}

/// Segments that a bend brings together are neighbours: nothing pushes them apart.
TEST(ThreadCrossing, ABendDoesNotTouchItself) {
  ThreadsAlone body;
  const Thread thread{.length = 0.01, .bending_stiffness = 0.0, .segment = 0.2e-3, .touches = true};
  body.scene.add_thread("thread", thread, {0, 0, 0}, {1, 0, 0});
  body.start();
  const double bend = 2.5 * thread.radius;
  lay_thread(body, "thread",
             laid_along([&](double t) { return Vec3(bend * std::cos(t), bend * std::sin(t), 2e-4 * t); }, 0.0, 51,
                        thread.segment));
  ASSERT_TRUE(body.solver->step(1, crossing_step).ok());
  EXPECT_TRUE(body.state("thread").touch.empty());
}

/// One that does not touch passes through another that does.
TEST(ThreadCrossing, OnlyThreadsThatTouchDo) {
  ThreadsAlone body;
  Thread thread{.length = 0.03, .touches = true};
  body.scene.add_thread("lower", thread, {-0.015, 0, 0}, {1, 0, 0});
  thread.touches = false;
  body.scene.add_thread("upper", thread, {0, -0.015, 1e-3}, {0, 1, 0});
  body.start();
  body.throw_at("upper", {0, 0, -1});
  ASSERT_TRUE(body.solver->step(10, crossing_step).ok());
  for (const Vec3& v : body.state("lower").velocity) EXPECT_LT(v.norm(), 1e-12);
  EXPECT_TRUE(body.state("upper").touch.empty());
}

/// Two that lie along each other: four times as many nodes take about four times as long. As their square it would be
/// 16 times.
TEST(ThreadCrossing, AStepCostsAsItsNodes) {
  std::array<double, 2> quickest{1.0, 1.0};  // s
  for (const std::size_t k : {0, 1}) {
    ThreadsAlone body;
    const Index nodes = k == 0 ? 50 : 200;
    const Thread thread{.length = 1e-3 * (nodes - 1), .segment = 1e-3, .touches = true};
    const ThreadHandle lower = body.scene.add_thread("lower", thread, {0, 0, 0}, {1, 0, 0});
    for (Index i = 0; i < nodes; ++i) lower.hold(i, {1e-3 * i, 0, 0});
    body.scene.add_thread("upper", thread, {2e-4, 0, 1.9 * thread.radius}, {1, 0, 0});
    body.scene.gravity({0, 0, -9.81});
    body.start();
    for (int step = 0; step < 15; ++step) {
      const auto start = std::chrono::steady_clock::now();
      ASSERT_TRUE(body.solver->step(1, crossing_step).ok());
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      quickest[k] = std::min(quickest[k], taken.count());
    }
    EXPECT_FALSE(body.state("upper").touch.empty());
  }
  std::printf("[ COST     ] %.0f us for 50, %.0f us for 200\n", 1e6 * quickest[0], 1e6 * quickest[1]);
  EXPECT_LT(quickest[1], 10.0 * quickest[0]);
}

/// A step depends on the state alone: a solver that is restored before each step does as one that is not.
TEST(ThreadCrossing, ARestoredStepHasTheSameBits) {
  std::array<ThreadsAlone, 2> bodies;
  for (ThreadsAlone& body : bodies) {
    const Thread thread{.length = 0.1, .segment = 10e-3, .touches = true, .friction = 0.3};
    body.scene.add_tool("floor", {.shape = HalfSpace{}});
    body.scene.add_thread("lower", thread, {0, 0, 0.2e-3}, {1, 0, 0});
    body.scene.add_thread("upper", thread, {1e-3, 0, 4.6e-3}, {1, 0, 0});
    body.scene.gravity({0.5, 2, -9.81});
    body.start();
  }
  State state = bodies[0].solver->read();
  for (int i = 0; i < 11; ++i) {
    state.threads[0].velocity[i] = Vec3(0.1 * (i % 3), 0.2 * std::sin(1.3 * i), -0.1 * (i % 2));
    state.threads[1].velocity[i] = Vec3(0, 0, -0.5);
  }
  bodies[0].solver->reset(state);
  for (int k = 0; k < 100; ++k) {
    bodies[1].solver->restore(bodies[0].solver->snapshot());
    for (ThreadsAlone& body : bodies) ASSERT_TRUE(body.solver->step(1, 1e-4).ok());
    ASSERT_EQ(bodies[0].solver->read(), bodies[1].solver->read()) << k;
  }
  EXPECT_LT(bodies[0].state("upper").position[5].z(), 1.1e-3) << "they met";
}

/// Some touch nothing, and two meet: the first time, their places are new.
TEST(ThreadCrossing, StepsAllocateNothing) {
  ThreadsAlone body;
  const Thread thread{.length = 0.03, .touches = true};
  for (const double y : {0.0, 0.1, 0.2}) body.scene.add_thread(std::to_string(y), thread, {0, y, 0}, {1, 0, 0});
  body.scene.add_thread("upper", thread, {0.01, -0.015, 0.97e-3}, {0, 1, 0});
  body.start();
  for (const bool is_first : {true, false}) {
    body.throw_at("upper", {0, 0, -1});
    const std::size_t before = allocation_count();
    for (int step = 0; step < 10; ++step) ASSERT_TRUE(body.solver->step(1, crossing_step).ok());
    if (!is_first) {
      EXPECT_EQ(allocation_count(), before);
    }
    EXPECT_GT(body.state("upper").velocity[5].z(), -0.9) << "they met";
    body.solver->reset();
  }
}

/// Threads that begin within each other part at a speed that short steps do not raise.
TEST(ThreadCrossing, DoesNotFlingApart) {
  for (const double dt : {1e-6, 1e-4}) {
    ThreadsAlone body;
    const Thread thread{.length = 0.03, .touches = true};
    body.scene.add_thread("lower", thread, {-0.015, 0, 0}, {1, 0, 0});
    body.scene.add_thread("upper", thread, {0, -0.015, 0.5 * thread.radius}, {0, 1, 0});
    body.start();
    for (int k = 0; k < 50; ++k) {
      ASSERT_TRUE(body.solver->step(1, dt).ok());
      for (const Vec3& velocity : body.state("upper").velocity) ASSERT_LT(velocity.norm(), 0.2) << dt << ", " << k;
    }
    EXPECT_GT(body.state("upper").velocity[5].z(), 0.0);
  }
}

}  // namespace
}  // namespace phymul::test
