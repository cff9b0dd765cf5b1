// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <gtest/gtest.h>
#include <limits>
#include <set>

#include "support/bodies.h"
#include "view/display_lists.h"

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

Vec3 corner_normal(const Model& model, const std::array<Index, 4>& face) {
  return (model.rest[face[1]] - model.rest[face[0]]).cross(model.rest[face[2]] - model.rest[face[0]]);
}

TEST(DisplayLists, SolidBodiesHaveAClosedSurface) {
  for (const Body& body : bodies()) {
    if (body.model.dimension == 2) continue;
    const DisplayLists lists = display_lists(body.model);
    std::set<Index> corners;
    std::size_t sides = 0;
    for (const auto& face : lists.faces) {
      for (const Index i : face) {
        if (i >= 0) corners.insert(i);
      }
      sides += face[3] < 0 ? 3 : 4;
    }
    EXPECT_EQ(2 * lists.edges.size(), sides) << body.name;
    EXPECT_EQ(corners.size() + lists.faces.size(), lists.edges.size() + 2) << body.name;  // Euler
    for (const SurfaceEdge& edge : lists.edges) EXPECT_GT((edge.normal[0] + edge.normal[1]).norm(), 0.1) << body.name;
  }
}

TEST(DisplayLists, FacesAreWoundOutward) {
  for (const Body& body : bodies()) {
    if (body.model.dimension == 2) continue;
    const DisplayLists lists = display_lists(body.model);
    const Vec3 centre = sum(body.model.rest) / body.model.particle_count();  // inside: all of them are convex
    for (const auto& face : lists.faces) {
      EXPECT_GT(corner_normal(body.model, face).dot(body.model.rest[face[0]] - centre), 0.0) << body.name;
    }
  }
}

TEST(DisplayLists, AMirroredCellIsWoundOutwardToo) {
  Model model = make_tetrahedron(0.01);
  std::swap(model.cells[0].particles[0], model.cells[0].particles[1]);
  const DisplayLists lists = display_lists(model);
  const Vec3 centre = sum(model.rest) / 4.0;
  for (const auto& face : lists.faces) {
    EXPECT_GT(corner_normal(model, face).dot(model.rest[face[0]] - centre), 0.0);
  }
}

TEST(DisplayLists, EveryLinkIsThereOnce) {
  for (const Body& body : bodies()) {
    EXPECT_EQ(2 * display_lists(body.model).links.size(), body.model.neighbours.entry.size()) << body.name;
  }
}

TEST(DisplayLists, APlaneBodyShowsItsCellsWithOpenEdges) {
  const Model strip = make_strip(0.04, 0.02, 4, 2);
  const DisplayLists lists = display_lists(strip);
  EXPECT_EQ(lists.faces.size(), 8u);
  EXPECT_EQ(lists.edges.size(), 4u * 3u + 5u * 2u);
  std::size_t open = 0;
  for (const SurfaceEdge& edge : lists.edges) open += (edge.normal[0] + edge.normal[1]).norm() < 1e-12;
  EXPECT_EQ(open, 2u * (4u + 2u));
}

}  // namespace
}  // namespace phymul::test
