// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <span>

#include "interaction/contact_points.h"

namespace phymul::test {
namespace {

/// Of random triangles on their way through a box: what the points keep out is all of the triangle, and no load jumps.
TEST(PointsInBox, KeepTheWholeTriangleOutAndChangeContinuously) {
  const Vec3 half(0.01, 0.012, 0.002);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int inside = 0;
  for (int trial = 0; trial < 200; ++trial) {
    BoxPlanes box{-half, half};
    if (trial % 2 == 1) box.low.z() *= 1.5;
    const auto deep = [&](const Vec3& q) { return (box.high - q).cwiseMin(q - box.low).minCoeff(); };
    std::array<Vec3, 3> at;
    for (Vec3& corner : at) corner = 0.015 * Vec3(unit(random), unit(random), 0.3 * unit(random));
    const Vec3 way = 1e-5 * Vec3(unit(random), unit(random), unit(random));
    const double area = 0.5 * (at[1] - at[0]).cross(at[2] - at[0]).norm();
    double before = -1.0;
    for (int step = 0; step < 20; ++step) {
      for (Vec3& corner : at) corner += way;
      const PointsInBox in(box, at, area);
      const auto place = [&](const auto& share) {
        return Vec3(share[0] * at[0] + share[1] * at[1] + share[2] * at[2]);
      };
      double load = 0.0, kept = 0.0, deepest = 0.0;
      for (const PointsInBox::Point& point : std::span(in.points).first(in.count)) {
        load += point.load;
        kept = std::max(kept, deep(place(point.share)));
      }
      for (int a = 0; a <= 20; ++a) {
        for (int b = 0; a + b <= 20; ++b) {
          deepest = std::max(deepest, deep(place(std::array{a / 20.0, b / 20.0, (20 - a - b) / 20.0})));
        }
      }
      inside += deepest > 0.0;
      ASSERT_GE(kept, 0.87 * deepest) << trial;
      // The triangle's area times what it goes deeper by, and the depth times the area that comes in.
      if (before >= 0.0) {
        ASSERT_NEAR(load, before, 4.0 * way.norm() * (area + 0.03 * half.z())) << trial;
      }
      before = load;
    }
  }
  EXPECT_GT(inside, 1000);
}

}  // namespace
}  // namespace phymul::test
