// SPDX-License-Identifier: MIT
//
// Free threads that touch themselves and each other (Thread::touches).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

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

double node_mass(const Thread& thread, const ThreadState& state, std::size_t i) {
  const auto segments = static_cast<double>(state.position.size()) - 1.0;
  const double mass = thread.density * std::numbers::pi * thread.radius * thread.radius * thread.length / segments;
  return i == 0 || i + 1 == state.position.size() ? 0.5 * mass : mass;
}

struct Motion {
  Vec3 momentum{0, 0, 0}, angular{0, 0, 0};
  double energy = 0.0;  // kinetic, of stretching and bending
};

void add(const Thread& thread, const ThreadState& state, Motion& sum) {
  const VecList &x = state.position, &v = state.velocity;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double mass = node_mass(thread, state, i);
    sum.momentum += mass * v[i];
    sum.angular += mass * x[i].cross(v[i]);
    sum.energy += 0.5 * mass * v[i].squaredNorm();
  }
  const double length = state.rest_length.front();
  for (const double tension : state.tension) sum.energy += 0.5 * tension * tension * length / axial_stiffness(thread);
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const Vec3 bend = x[i + 1] - 2.0 * x[i] + x[i - 1];
    sum.energy += 0.5 * bending_stiffness(thread) * bend.squaredNorm() / (length * length * length);
  }
}

/// m: of two segments, from samples of one.
double apart(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= 20; ++k) {
    const Vec3 p = a + 0.05 * k * (b - a);
    const double share = std::clamp((p - c).dot(d - c) / (d - c).squaredNorm(), 0.0, 1.0);
    least = std::min(least, (c + share * (d - c) - p).norm());
  }
  return least;
}

double apart(const VecList& x, const VecList& y) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p + 1 < x.size(); ++p) {
    for (std::size_t q = 0; q + 1 < y.size(); ++q) least = std::min(least, apart(x[p], x[p + 1], y[q], y[q + 1]));
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
        Motion before;
        for (const char* const name : {"lower", "upper"}) add(thread, body.state(name), before);
        double energy = before.energy, nearest = 1.0;
        for (int k = 0; k < 60; ++k) {
          ASSERT_TRUE(body.solver->step(1, crossing_step).ok());
          Motion now;
          for (const char* const name : {"lower", "upper"}) add(thread, body.state(name), now);
          ASSERT_LT((now.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm()) << k;
          ASSERT_LT(now.energy, (1.0 + 1e-9) * energy) << k;
          energy = now.energy;
          nearest = std::min(nearest, apart(body.state("lower").position, body.state("upper").position));
        }
        Motion upper;
        add(thread, body.state("upper"), upper);
        EXPECT_GT(nearest, 0.98 * 2.0 * thread.radius);
        EXPECT_GT(upper.momentum.z() / before.momentum.z(), 0.1);
        EXPECT_LT(upper.momentum.z() / before.momentum.z(), 0.9) << "the lower one was hit";
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test
