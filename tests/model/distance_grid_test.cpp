// SPDX-License-Identifier: MIT
//
// Shapes from meshes: distances against closed forms, and what is refused.
#include <cmath>
#include <random>

#include "interaction/distance_to_shape.h"
#include "model/closest_triangle.h"
#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

double box_distance(const Vec3& x, const Vec3& low, const Vec3& high) {
  const Vec3 half = 0.5 * (high - low), q = x - 0.5 * (low + high);
  return distance_from_box<double>({q.x(), q.y(), q.z()}, {half.x(), half.y(), half.z()}).phi;
}

TEST(DistanceGrid, OfABoxIsItsDistance) {
  const Model model = make_block({0.03, 0.02, 0.01}, 3, 2, 1);
  const auto grid = make_distance_grid(model, 0.0013);
  const auto [nx, ny, nz] = grid->count();
  EXPECT_NEAR(grid->depth(), 0.005, 0.0007);
  std::size_t at = 0;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i, ++at) {
        const Vec3 x = grid->origin() + 0.0013 * Vec3(i, j, k);
        ASSERT_NEAR(grid->values()[at], box_distance(x, Vec3::Zero(), {0.03, 0.02, 0.01}), 1e-9) << x.transpose();
      }
    }
  }
}

/// A star of two spikes: corners and edges where a face's own normal has the wrong sign.
Model spiked() {
  Model model;
  model.rest = {{0, 0, 0.05}, {0, 0, -0.05}, {0.01, 0, 0}, {0, 0.01, 0}, {-0.01, 0, 0}, {0, -0.01, 0}};
  model.mass.assign(6, 1.0);
  model.stiffness.assign(6, 1.0);
  const auto face = [&](Index a, Index b, Index c) {
    model.cells.push_back({.type = CellType::triangle, .particles = {a, b, c}});
  };
  for (Index k = 0; k < 4; ++k) {
    face(0, 2 + k, 2 + (k + 1) % 4);
    face(1, 2 + (k + 1) % 4, 2 + k);
  }
  model.neighbours = neighbours_from_cells(model.cells, 6);
  return model;
}

TEST(DistanceGrid, KnowsInsideFromOutsideAtSharpCorners) {
  const Model model = spiked();
  std::vector<Triangle> triangles;
  for (const Cell& cell : model.cells) {
    triangles.push_back({cell.particles[0], cell.particles[1], cell.particles[2]});
  }
  const ClosestTriangle closest(model.rest, triangles);
  std::mt19937 bits(3);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 x = 0.06 * random_vector(bits, 3).cwiseProduct(Vec3(0.3, 0.3, 1.0));
    // |x| + |y| <= 0.01 (1 - |z| / 0.05)
    const double out = std::abs(x.x()) + std::abs(x.y()) - 0.01 * (1.0 - std::abs(x.z()) / 0.05);
    if (std::abs(out) < 1e-9) continue;
    ASSERT_EQ(closest.signed_distance(x) > 0.0, out > 0.0) << x.transpose();
  }
  EXPECT_NEAR(closest.signed_distance({0, 0, 0.06}), 0.01, 1e-15);
}

TEST(DistanceGrid, WhatIsNotClosedIsRefusedByItsEdge) {
  Model open = spiked();
  open.cells.erase(open.cells.begin());  // 0, 2, 3
  EXPECT_TRUE(refuses([&] { make_distance_grid(open, 0.002); },
                      "not closed, or not wound one way: the edge from particle 0 to 3"));
  Model turned = spiked();
  std::swap(turned.cells[0].particles[1], turned.cells[0].particles[2]);
  EXPECT_TRUE(refuses([&] { make_distance_grid(turned, 0.002); }, "not wound one way"));
  Model sliver = spiked();  // off the line from 0 to 2 by rounding
  sliver.rest.push_back(0.5 * (sliver.rest[0] + sliver.rest[2]) + Vec3(0, 1e-15, 0));
  sliver.mass.push_back(1.0);
  sliver.stiffness.push_back(1.0);
  for (const auto& [a, b, c] : {Triangle{0, 6, 3}, Triangle{6, 2, 3}, Triangle{0, 2, 6}}) {
    sliver.cells.push_back({.type = CellType::triangle, .particles = {a, b, c}});
  }
  sliver.cells.erase(sliver.cells.begin());
  sliver.neighbours = neighbours_from_cells(sliver.cells, 7);
  EXPECT_TRUE(refuses([&] { make_distance_grid(sliver, 0.002); }, "particles 0, 2 and 6 has no area"));
  EXPECT_TRUE(refuses([] { make_distance_grid(spiked(), 1e-6); }, "more than 64 million"));
  EXPECT_TRUE(refuses([] { make_distance_grid(spiked(), -1.0); }, "spacing above 0 m, got -1"));
  EXPECT_TRUE(refuses(
      [] {
        DistanceGrid(Vec3::Zero(), 1.0, {2, 2, 2}, std::vector<float>(8, 1.0f));
      },
      "no corner lies inside"));
  EXPECT_NO_THROW(make_distance_grid(spiked(), 0.002));
}

using GridTool = WithTools;
PHYMUL_ON_EVERY_BACKEND(GridTool);

/// The distances of a ball's surface at the corners of cubes.
std::shared_ptr<const DistanceGrid> ball_grid(double radius, double spacing) {
  const int cubes = 2 * static_cast<int>(std::ceil(radius / spacing)) + 4, n = cubes + 1;
  const Vec3 origin = Vec3::Constant(-0.5 * spacing * cubes);
  std::vector<float> values;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        values.push_back(static_cast<float>((origin + spacing * Vec3(i, j, k)).norm() - radius));
      }
    }
  }
  return std::make_shared<const DistanceGrid>(origin, spacing, std::array<int, 3>{n, n, n}, std::move(values));
}

TEST_P(GridTool, PressesAsTheSameBallDoes) {
  const Model model = soft_block({0.03, 0.03, 0.02}, 6, 6, 4);
  const auto press = [&](const ToolShape& shape) {
    Scene scene(model);
    ToolPose pose{.position = Vec3(0.015, 0.014, 0.0285),
                  .orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3(0.2, 1, 0).normalized()))};
    scene.fix("z0").add_tool("tool", {.shape = shape, .pose = pose, .friction = 0.3});
    const auto solver = make(model, scene, damped(40.0));
    pose.position.z() -= 0.003;
    scene.tool("tool").move_to(pose);
    EXPECT_TRUE(solver->step(300, 0.4 * solver->stable_step()).ok());
    EXPECT_GT(solver->tool_force("tool").particles, 3);
    return solver->tool_force("tool").mean_force;
  };
  const Vec3 closed_form = press(Sphere{0.008}), grid = press(ball_grid(0.008, 0.5e-3));
  EXPECT_GT(closed_form.z(), 0.02);
  EXPECT_LE((closed_form - grid).norm(), 0.02 * closed_form.norm());
}

}  // namespace
}  // namespace phymul::test
