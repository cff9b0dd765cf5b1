// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/camera.h>
#include <phymul/display.h>
#include <phymul/error.h>

#include <limits>

#include "support/bodies.h"

namespace phymul::test {
namespace {

const Vec3 directions[] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {0.5, -1, 0.4}, {-3, 2, 1}};

TEST(Camera, PixelsAndPointsAreEachOthersInverse) {
  std::mt19937 bits(3);
  for (const Vec3& direction : directions) {
    for (const double angle : {0.0, 0.7}) {
      const Camera camera = framing(make_tetrahedron(0.01).rest, direction, 1.5, angle);
      for (int k = 0; k < 20; ++k) {
        const Vec3 point = camera.target + 0.004 * random_vector(bits, 3);
        const Vec3 pixel = to_pixel(camera, point, 300, 200);
        EXPECT_LT((from_pixel(camera, pixel, 300, 200) - point).norm(), 1e-12);
      }
    }
  }
}

TEST(Camera, TheTargetIsInTheMiddleAndUpIsUp) {
  const Camera camera{.eye = {0, -2, 0}, .up = {0, 0, 1}};
  EXPECT_TRUE(to_pixel(camera, {0, 0, 0}, 100, 50).isApprox(Vec3(50, 25, 2)));
  EXPECT_TRUE(to_pixel(camera, {0.1, 0, 0}, 100, 50).isApprox(Vec3(55, 25, 2)));  // 50 pixels a metre
  EXPECT_TRUE(to_pixel(camera, {0, 0, 0.1}, 100, 50).isApprox(Vec3(50, 20, 2)));
  EXPECT_DOUBLE_EQ(pixels_per_metre(camera, {0, 0, 0}, 50), 50.0);
}

TEST(Camera, NearerThingsAreLargerInPerspective) {
  const Camera camera{.eye = {0, 0, 2}, .view_angle = 1.0};
  EXPECT_GT(pixels_per_metre(camera, {0, 0, 1}, 100), 1.99 * pixels_per_metre(camera, {0, 0, 0}, 100));
}

TEST(Camera, FramingSeesEveryPointAndFillsThePicture) {
  for (const Body& body : bodies()) {
    for (const Vec3& direction : directions) {
      for (const double angle : {0.0, 0.6}) {
        for (const double aspect : {0.5, 2.0}) {
          const int height = 400, width = static_cast<int>(height * aspect);
          const Camera camera = framing(body.model.rest, direction, aspect, angle);
          double reach = 0.0;
          for (const Vec3& x : body.model.rest) {
            const Vec3 seen = to_pixel(camera, x, width, height);
            EXPECT_GT(seen.z(), 0.0) << body.name;
            reach = std::max({reach, std::abs(2.0 * seen.x() / width - 1.0), std::abs(2.0 * seen.y() / height - 1.0)});
          }
          EXPECT_LE(reach, 1.0) << body.name << ' ' << direction.transpose();
          if (angle == 0.0) {
            EXPECT_GT(reach, body.model.dimension == 3 ? 0.94 : 0.0) << body.name;
          }
        }
      }
    }
  }
}

TEST(Camera, WhatCannotBeSeenIsRefused) {
  EXPECT_THROW(framing({}, Vec3::UnitX()), Error);
  VecList points = make_tetrahedron(0.01).rest;
  EXPECT_THROW(framing(points, Vec3::Zero()), Error);
  for (const double angle : {-0.5, 3.2, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(framing(points, Vec3::UnitX(), 1.0, angle), Error) << angle;
  }
  points.back().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(framing(points, Vec3::UnitX()), Error);
  Camera camera;
  camera.eye = camera.target;
  EXPECT_THROW(axes_of(camera), Error);
  camera.eye = camera.target + camera.up;
  EXPECT_THROW(axes_of(camera), Error);
}

TEST(Camera, ASinglePointHasAPicture) {
  const VecList point{{1.0, 2.0, 3.0}};
  const Camera camera = framing(point, Vec3::UnitX());
  EXPECT_TRUE(to_pixel(camera, point[0], 10, 10).head<2>().isApprox(Eigen::Vector2d(5, 5)));
}

TEST(DisplacementColour, IsOfTheNearestShareOfTheScale) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  for (const double share : {nan, -1.0, -infinite}) {
    EXPECT_EQ(displacement_colour(share), displacement_colour(0.0)) << share;
  }
  for (const double share : {2.0, infinite}) EXPECT_EQ(displacement_colour(share), displacement_colour(1.0)) << share;
}

}  // namespace
}  // namespace phymul::test
