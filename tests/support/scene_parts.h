// SPDX-License-Identifier: MIT
//
// Loads and frames for tests of scenes.
#pragma once

#include <gtest/gtest.h>
#include <phymul/load_frame.h>
#include <phymul/scene.h>

#include <utility>
#include <vector>

namespace phymul {

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

}  // namespace phymul
