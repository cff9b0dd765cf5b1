// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/shapes.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "support/message_of.h"

namespace phymul {
namespace {

using Triangles = std::vector<std::array<Index, 3>>;

/// What the triangles enclose, m^3, as positive as they point outward.
double enclosed(const Triangles& triangles, const VecList& x) {
  double volume = 0.0;
  for (const auto& [a, b, c] : triangles) volume += x[a].dot(x[b].cross(x[c])) / 6.0;
  return volume;
}

/// Every edge is walked once each way: closed, and wound alike throughout.
bool is_closed(const Triangles& triangles) {
  std::map<std::pair<Index, Index>, int> walked;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) ++walked[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, times] : walked) {
    if (times != 1 || !walked.contains({edge.second, edge.first})) return false;
  }
  return true;
}

TEST(Surface, TrianglesCloseABodyAndPointOutward) {
  const Model block = make_block({0.2, 0.1, 0.1}, 4, 2, 3), cylinder = make_cylinder(0.01, 0.04, 3, 8, 11),
              tetrahedra = make_tetrahedral_block({0.1, 0.1, 0.1}, 3, 3, 3, 0.2, 7);
  for (const Model* model : {&block, &cylinder, &tetrahedra}) {
    const Triangles triangles = surface_triangles(*model);
    double volume = 0.0;
    for (const Cell& cell : model->cells) volume += cell_volume(*model, cell);
    EXPECT_TRUE(is_closed(triangles));
    EXPECT_NEAR(enclosed(triangles, model->rest), volume, 2e-3 * volume);
  }
  EXPECT_EQ(surface_triangles(block).size(), 2u * 2u * (4 * 2 + 4 * 3 + 2 * 3));
}

TEST(Surface, TrianglesOfACellThatIsInsideOutPointOutwardToo) {
  Model model = make_tetrahedron(0.01);
  std::swap(model.cells[0].particles[0], model.cells[0].particles[1]);
  EXPECT_TRUE(is_closed(surface_triangles(model)));
  EXPECT_GT(enclosed(surface_triangles(model), model.rest), 0.0);
}

TEST(Surface, TrianglesOfPlanesAndOfBodiesWithoutVolume) {
  Model strip = make_strip(0.04, 0.02, 4, 2);
  std::ranges::reverse(strip.cells.front().particles);
  Triangles triangles = surface_triangles(strip);
  EXPECT_EQ(triangles.size(), 16u);
  VecList normal;
  surface_normals(triangles, strip.rest, normal);
  for (const Vec3& n : normal) EXPECT_NEAR((n - Vec3::UnitZ()).norm(), 0.0, 1e-12);

  Model shell = make_strip(0.04, 0.02, 4, 2);
  shell.dimension = 3;
  EXPECT_EQ(surface_triangles(shell).size(), 16u);
  shell.cells.clear();
  shell.components.clear();
  EXPECT_TRUE(surface_triangles(shell).empty());
}

TEST(Surface, NormalsFollowTheBody) {
  const Model model = make_block({0.2, 0.2, 0.2}, 2, 2, 2);
  const Triangles triangles = surface_triangles(model);
  const Mat3 turn = Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  VecList turned = model.rest;
  for (Vec3& x : turned) x = turn * x + Vec3(1, 0, 0);
  VecList normal;
  surface_normals(triangles, turned, normal);
  ASSERT_EQ(normal.size(), model.rest.size());
  const Vec3 middle = Vec3::Constant(0.1);
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const Vec3 out = model.rest[i] - middle;
    const auto sides = (out.array().abs() > 1e-9).count();
    if (sides == 0) {
      EXPECT_EQ(normal[i], Vec3(Vec3::Zero()));
    } else if (sides == 1) {
      EXPECT_NEAR((normal[i] - turn * out.normalized()).norm(), 0.0, 1e-12);
    } else {
      EXPECT_NEAR(normal[i].norm(), 1.0, 1e-12);
      EXPECT_GT(normal[i].dot(turn * out.normalized()), 0.8);
    }
  }
  turned.pop_back();
  EXPECT_TRUE(refuses([&] { surface_normals(triangles, turned, normal); }, "0 to 25, got 26"));
}

TEST(Surface, PicksTheFrontmostParticleNearTheRay) {
  const VecList x = {{0, 0, 3}, {0.01, 0, 2}, {0.3, 0, 1}, {0, 0, -1}, {0, 0, std::nan("")}, {0, 0, 0.5}};
  Model model;
  model.mass = {1, 1, 1, 1, 1, 0};  // kg: nothing is at the last one, as at a spare particle
  PickRay ray{.origin = {0, 0, 0}, .direction = {0, 0, 7}};
  EXPECT_EQ(pick_particle(model, x, ray), 0);
  ray.reach = 0.02;
  EXPECT_EQ(pick_particle(model, x, ray), 1);
  ray.widening = 0.29;
  EXPECT_EQ(pick_particle(model, x, ray), 2);
  ray.direction = {0, 0, -1};
  EXPECT_EQ(pick_particle(model, x, ray), 3);
  ray.direction = {0, 1, 0};
  ray.widening = 0.0;
  EXPECT_EQ(pick_particle(model, x, ray), -1);
  ray.direction = Vec3::Zero();
  EXPECT_TRUE(refuses([&] { pick_particle(model, x, ray); }, "direction that is not zero"));
  EXPECT_TRUE(refuses([&] { pick_particle(model, model.rest, ray); }, "expected 6 positions, got 0"));
}

}  // namespace
}  // namespace phymul
