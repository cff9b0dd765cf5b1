// SPDX-License-Identifier: MIT
//
// Particles without any stiffness of their own, for joints and threads alone to move. Loads and frames for tests of
// scenes.
#pragma once

#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/phymul.h>
#include <phymul/scene.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "bodies.h"

namespace phymul::test {

inline Model loose_particles(VecList rest, double mass) {
  Model model;
  model.mass.assign(rest.size(), mass);
  model.stiffness.assign(rest.size(), 0.0);
  for (std::size_t i = 0; i < rest.size(); ++i) model.neighbours.push_row<const Index*>(nullptr, nullptr);
  model.rest = std::move(rest);
  return model;
}

/// Of loose particles.
inline std::unique_ptr<Solver> loose_solver(const std::string& backend, const Model& model, const Scene& scene,
                                            const SolverOptions& options = {}) {
  return make_solver(backend, model, scene, {.law = Law::springs}, options);
}

inline constexpr double stitch_dt = 0.5e-3;  // s

/// A thread through particles that are held, in a zigzag in space.
struct Zigzag {
  explicit Zigzag(const Thread& constants, int passages = 5)
      : model(loose_particles(places(passages), 1e-3)), scene(model) {
    scene.fix(every_particle(model));
    std::vector<Anchor> anchors;
    for (Index i = 0; i < passages; ++i) anchors.push_back(at_particle(i));
    thread.emplace(scene.sew("thread", constants, anchors));
    solver = loose_solver("reference", model, scene);
  }
  static VecList places(int count) {
    VecList places;
    for (int k = 0; k < count; ++k) places.emplace_back(0.01 * k, k % 2 == 0 ? 0.0 : 0.012, 0.004 * (k % 3));
    return places;
  }
  const ThreadState& state() const { return solver->thread_state(*thread); }
  void run(int steps) { ASSERT_TRUE(solver->step(steps, stitch_dt).ok()); }
  /// rad, at passage p.
  double wrap(std::size_t p) const {
    const VecList& x = state().position;
    const Vec3 before = x[p + 1] - x[p], after = x[p + 2] - x[p + 1];
    return std::atan2(before.cross(after).norm(), before.dot(after));
  }
  double length() const { return std::accumulate(state().rest_length.begin(), state().rest_length.end(), 0.0); }

  Model model;
  Scene scene;
  std::optional<ThreadHandle> thread;
  std::unique_ptr<Solver> solver;
};

inline Load made(LoadType type, std::vector<Index> particles, const Vec3& direction, double value) {
  return {.type = type, .particles = std::move(particles), .events = {{0.0, value}}, .direction = direction};
}

inline LoadFrame at(const Scene& scene, double time) {
  LoadFrame frame;
  scene.prepare(frame);
  scene.evaluate(time, frame);
  return frame;
}

inline void expect_near(const Vec3& got, const Vec3& expected, double tolerance = 1e-14) {
  EXPECT_NEAR((got - expected).norm(), 0.0, tolerance) << got.transpose() << " instead of " << expected.transpose();
}

inline Vec3 total_of(const VecList& list) {
  Vec3 total = Vec3::Zero();
  for (const Vec3& v : list) total += v;
  return total;
}

}  // namespace phymul::test
