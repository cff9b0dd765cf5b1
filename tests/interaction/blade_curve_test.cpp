// SPDX-License-Identifier: MIT
//
// The edge of a curved blade, and the surface that it cuts.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "interaction/tool_shape.h"

namespace phymul {
namespace {

TEST(BladeCurve, IsUnrolled) {
  for (const double bow : {-0.01, -0.004, 0.0, 0.007, 0.01}) {
    for (const double belly : {-0.003, 0.0, 0.01}) {
      const BladeCurve curve({.width = 0.02, .belly = belly, .bow = bow});
      double length = 0.0;  // of the edge
      for (int k = 0; k < 400; ++k) {
        const double along = curve.length() * ((k + 0.5) / 400 - 0.5);
        const Vec3 off = 0.002 * curve.normal(along), behind(0, 0, 0.005);
        EXPECT_LT((curve.unrolled(curve.at(along) + off + behind) - Vec3(along, 0.002, 0.005)).norm(), 1e-12);
        length += curve.stretch(along) * curve.length() / 400;
        const Vec3 across = curve.at(along + 1e-7) - curve.at(along - 1e-7);
        EXPECT_LT(std::abs(across.normalized().dot(curve.way(along))), 1e-5);
        EXPECT_NEAR(curve.way(along).dot(curve.normal(along)), 0.0, 1e-12);
        EXPECT_LT(curve.way(along).z(), 0.0);
      }
      const Vec3 end = curve.at(0.5 * curve.length());
      EXPECT_LT((end - Vec3(0.01, -bow, belly)).norm(), 1e-12);
      if (bow == 0.0 && belly == 0.01) {
        EXPECT_NEAR(length, 0.01 * std::numbers::pi, 1e-3);
      }
      if (bow == 0.0) continue;
      // Where a whole circle would come back to: the surface is nowhere near.
      const double across = (0.25 * 0.02 * 0.02 / std::abs(bow) + std::abs(bow));
      EXPECT_GT(std::abs(curve.unrolled({1e-4, -std::copysign(across, bow), 0}).y()), 0.4 * across);
    }
  }
}

}  // namespace
}  // namespace phymul
