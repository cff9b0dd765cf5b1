// SPDX-License-Identifier: MIT
#include "view/display_lists.h"

#include <gtest/gtest.h>

#include <set>

#include "support/bodies.h"

namespace phymul::test {
namespace {

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
