// SPDX-License-Identifier: MIT
#include "body/improve_cells.h"

#include <gtest/gtest.h>

namespace phymul::test {
namespace {

/// The middle of an octahedron's eight cells, moved to `place`, and where improve_cells() puts it.
Vec3 improved(const Vec3& place) {
  Stuffing body{.place = {place}, .at_surface = std::vector<char>(7, 0), .cells = {}, .leaf_edge = {}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) body.place.push_back(side * Vec3::Unit(axis));
  }
  for (const Index x : {1, 2}) {
    for (const Index y : {3, 4}) {
      for (const Index z : {5, 6}) {
        Tetrahedron cell{0, x, y, z};
        if (((x == 1) != (y == 3)) != (z == 5)) std::swap(cell[1], cell[2]);
        body.cells.push_back(cell);
      }
    }
  }
  improve_cells(body, {});
  double smallest = 10.0;
  for (const Tetrahedron& cell : body.cells) {
    smallest = std::min(smallest, dihedral_angles(corners_of(cell, body.place)).smallest);
  }
  EXPECT_GT(smallest, 15.0 / 57.3) << place.transpose();
  return body.place.front();
}

TEST(ImproveCells, SearchesAlikeOnAllSides) {
  for (const Vec3& place :
       {Vec3(0.8, 0.05, 0.02), Vec3(0.85, 0.03, 0.004), Vec3(0.9, 0.01, 0.002), Vec3(0.5, 0.4, 0.03)}) {
    const Vec3 there = improved(place);
    EXPECT_LT(there.norm(), 0.95 * place.norm());
    for (int signs = 0; signs < 8; ++signs) {
      const Vec3 side(signs & 1 ? -1 : 1, signs & 2 ? -1 : 1, signs & 4 ? -1 : 1);
      for (int axis = 0; axis < 3; ++axis) {
        const auto turned = [&](const Vec3& v) {
          return Vec3(side.cwiseProduct(Vec3(v[axis], v[(axis + 1) % 3], v[(axis + 2) % 3])));
        };
        EXPECT_LT((improved(turned(place)) - turned(there)).norm(), 1e-12) << turned(place).transpose();
      }
    }
  }
}

}  // namespace
}  // namespace phymul::test
