// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "model/cell_geometry.h"
#include "support/message_of.h"

namespace phymul {
namespace {

double total_volume(const Model& model) {
  double sum = 0.0;
  for (const Cell& cell : model.cells) sum += signed_measure(model.dimension, cell, model.rest);
  return sum;
}

double least_volume(const Model& model) {
  double least = INFINITY;
  for (const Cell& cell : model.cells) least = std::min(least, signed_measure(model.dimension, cell, model.rest));
  return least;
}

int most_neighbours(const Model& model) {
  int most = 0;
  for (Index i = 0; i < model.neighbours.rows(); ++i) most = std::max(most, static_cast<int>(model.neighbours.size(i)));
  return most;
}

void expect_sorted_and_mutual(const RaggedList& list) {
  std::set<std::pair<Index, Index>> pairs;
  for (Index i = 0; i < list.rows(); ++i) {
    EXPECT_TRUE(std::is_sorted(list.begin(i), list.end(i)));
    for (const Index* j = list.begin(i); j != list.end(i); ++j) pairs.insert({i, *j});
  }
  EXPECT_EQ(pairs.size(), list.entry.size());
  for (const auto& [i, j] : pairs) EXPECT_TRUE(i != j && pairs.count({j, i}) == 1);
}

TEST(Tetrahedron, IsRegular) {
  const Model model = make_tetrahedron(0.02);
  for (Index i = 0; i < 4; ++i) {
    EXPECT_EQ(model.neighbours.size(i), 3);
    for (Index j = 0; j < i; ++j) EXPECT_NEAR((model.rest[i] - model.rest[j]).norm(), 0.02, 1e-15);
  }
  EXPECT_NEAR(total_volume(model), 0.02 * 0.02 * 0.02 / (6 * std::sqrt(2.0)), 1e-18);
  EXPECT_EQ(model.group("base"), (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(model.group("apex"), (std::vector<Index>{3}));
}

class BlockValence : public testing::TestWithParam<int> {};

TEST_P(BlockValence, CountsNeighboursInsideAndAtTheCorner) {
  const Model model = make_block({0.4, 0.5, 0.6}, 4, 5, 6, GetParam());
  EXPECT_EQ(model.particle_count(), 5 * 6 * 7);
  EXPECT_EQ(model.cells.size(), 4u * 5u * 6u);
  EXPECT_EQ(most_neighbours(model), GetParam());
  const std::map<int, int> at_corner{{6, 3}, {14, 4}, {18, 6}, {26, 7}};
  EXPECT_EQ(model.neighbours.size(0), at_corner.at(GetParam()));
  expect_sorted_and_mutual(model.neighbours);
  EXPECT_NEAR(total_volume(model), 0.12, 1e-14);
  EXPECT_TRUE(find_flaws(model).empty());
  EXPECT_EQ(model.rest[1], Vec3(0.1, 0, 0));  // x runs fastest
  EXPECT_EQ(model.rest.back(), Vec3(0.4, 0.5, 0.6));
}

INSTANTIATE_TEST_SUITE_P(All, BlockValence, testing::Values(6, 14, 18, 26));

TEST(Block, SixNeighboursAreTheCellEdges) {
  const Model model = make_block({1, 1, 1}, 3, 2, 4);
  EXPECT_EQ(model.neighbours, neighbours_from_cells(model.cells, model.particle_count()));
}

TEST(Block, GroupsAreTheSides) {
  const Model model = make_block({1, 2, 3}, 2, 3, 4);
  const auto expect_side = [&](const char* name, int axis, double place, std::size_t count) {
    const std::vector<Index> side = model.group(name);
    EXPECT_EQ(side.size(), count) << name;
    for (const Index i : side) EXPECT_EQ(model.rest[i][axis], place) << name;
  };
  expect_side("x0", 0, 0.0, 20);
  expect_side("x1", 0, 1.0, 20);
  expect_side("y0", 1, 0.0, 15);
  expect_side("y1", 1, 2.0, 15);
  expect_side("z0", 2, 0.0, 12);
  expect_side("z1", 2, 3.0, 12);
}

TEST(Shapes, RefuseSenselessArguments) {
  EXPECT_TRUE(refuses([] { make_block({1, 1, 1}, 2, 2, 2, 7); }, "valence of 6, 14, 18 or 26, got 7"));
  EXPECT_TRUE(refuses([] { make_block({1, 1, 1}, 2, 0, 2); }, "ny of at least 1, got 0"));
  EXPECT_TRUE(refuses([] { make_block({1, 1, 1}, 2, 2, -1); }, "nz of at least 1, got -1"));
  EXPECT_TRUE(refuses([] { make_block({1, 1, -1}, 2, 2, 2); }, "size along z"));
  EXPECT_TRUE(refuses([] { make_block({1, NAN, 1}, 2, 2, 2); }, "size along y"));
  EXPECT_TRUE(refuses([] { make_block({1, 1, 1}, 2000, 2000, 2000); }, "ask for fewer cells"));
  EXPECT_TRUE(refuses([] { make_tetrahedron(0.0); }, "positive, finite edge"));
  EXPECT_TRUE(refuses([] { make_cylinder(0.01, 0.04, 0, 8, 11); }, "rings of at least 1"));
  EXPECT_TRUE(refuses([] { make_cylinder(0.01, 0.04, 3, 2, 11); }, "sectors of at least 3"));
  EXPECT_TRUE(refuses([] { make_cylinder(0.01, 0.04, 3, 8, 1); }, "discs of at least 2"));
  EXPECT_TRUE(refuses([] { make_cylinder(0.01, INFINITY, 3, 8, 2); }, "finite length"));
  EXPECT_TRUE(refuses([] { make_cylinder(0.01, 0.04, 50000, 50000, 2); }, "ask for fewer cells"));
  EXPECT_TRUE(refuses([] { make_strip(1, 1, 0, 2); }, "nx of at least 1"));
  EXPECT_TRUE(refuses([] { make_tetrahedral_block({1, 1, 1}, 2, 2, 2, 0.5, 0); }, "below 0.5 spacings"));
  EXPECT_TRUE(refuses([] { make_tetrahedral_block({1, 1, 1}, 2, 2, 0, 0.1, 0); }, "nz of at least 1"));
  Model model = make_tetrahedron(1.0);
  EXPECT_TRUE(refuses([&] { jitter(model, -0.1, 0); }, "0 or more spacings"));
}

TEST(Cylinder, IsLaidOutAsTheSampleBody) {
  const Model model = make_cylinder(0.010, 0.040, 3, 8, 11);
  const Model sample = read_pml(PHYMUL_SAMPLE_DATA "/cylinder_275.pml");
  ASSERT_EQ(model.particle_count(), 275);
  ASSERT_EQ(sample.particle_count(), 275);
  for (Index i = 0; i < 275; ++i) EXPECT_NEAR((model.rest[i] - sample.rest[i]).norm(), 0.0, 1e-9 * 0.040);
  ASSERT_EQ(model.cells.size(), 240u);
  ASSERT_EQ(sample.cells.size(), 240u);
  for (std::size_t row = 0; row < 240; ++row) {
    EXPECT_EQ(model.cells[row].type, sample.cells[row].type);
    EXPECT_EQ(model.cells[row].particles, sample.cells[row].particles);
  }
  for (Index i = 0; i < 275; ++i) {
    const std::set<Index> ours(model.neighbours.begin(i), model.neighbours.end(i));
    const std::set<Index> theirs(sample.neighbours.begin(i), sample.neighbours.end(i));
    EXPECT_EQ(ours, theirs) << "particle " << i;
  }
}

TEST(Cylinder, FillsItsPrismAndNamesItsEnds) {
  const Model model = make_cylinder(0.02, 0.1, 2, 6, 5);
  const double hexagon = 0.5 * 6 * 0.02 * 0.02 * std::sin(std::numbers::pi / 3);
  EXPECT_NEAR(total_volume(model), 0.1 * hexagon, 1e-12 * 0.1 * hexagon);
  EXPECT_GT(least_volume(model), 0.0);
  EXPECT_TRUE(find_flaws(model).empty());
  EXPECT_EQ(model.group("bottom").size(), 13u);
  for (const Index i : model.group("top")) EXPECT_EQ(model.rest[i].z(), 0.1);
  EXPECT_EQ(model.group("side").size(), 30u);
  for (const Index i : model.group("side")) EXPECT_NEAR(model.rest[i].head<2>().norm(), 0.02, 1e-16);
  EXPECT_EQ(make_cylinder(1, 1, 1, 3, 2).cells.size(), 3u);
}

TEST(Strip, IsPlaneWithOrWithoutDiagonals) {
  const Model plain = make_strip(0.4, 0.2, 4, 2), crossed = make_strip(0.4, 0.2, 4, 2, true);
  EXPECT_EQ(plain.dimension, 2);
  EXPECT_EQ(plain.particle_count(), 15);
  EXPECT_NEAR(total_volume(plain), 0.08, 1e-15);
  EXPECT_EQ(most_neighbours(plain), 4);
  EXPECT_EQ(most_neighbours(crossed), 8);
  EXPECT_EQ(crossed.neighbours.size(0), 3);
  expect_sorted_and_mutual(crossed.neighbours);
  EXPECT_EQ(plain.cells, crossed.cells);
  EXPECT_EQ(plain.group("y1").size(), 5u);
  EXPECT_FALSE(plain.has_group("z0"));
  EXPECT_TRUE(find_flaws(plain).empty());
}

/// How often each triangle occurs as the face of a tetrahedron.
std::map<std::set<Index>, int> face_counts(const Model& model) {
  std::map<std::set<Index>, int> count;
  for (const Cell& cell : model.cells) {
    for (const CellFace& face : cell_faces(cell.type)) {
      ++count[{cell.particles[face[0]], cell.particles[face[1]], cell.particles[face[2]]}];
    }
  }
  return count;
}

double open_area(const Model& model) {
  double sum = 0.0;
  for (const auto& [face, count] : face_counts(model)) {
    EXPECT_LE(count, 2);
    if (count == 1) sum += area_vector(std::vector<Index>(face.begin(), face.end()), model.rest).norm();
  }
  return sum;
}

TEST(TetrahedralBlock, IsConformingPositiveAndExact) {
  for (const double amount : {0.0, 0.1, 0.25, 0.49}) {
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
      const Model model = make_tetrahedral_block({0.1, 0.2, 0.3}, 5, 6, 7, amount, seed);
      EXPECT_EQ(model.cells.size(), 6u * 5u * 6u * 7u);
      EXPECT_GE(least_volume(model), 0.1 * 0.006 / (6 * 210) * (1 - 1e-9));
      EXPECT_NEAR(total_volume(model), 0.006, 1e-15);
      // Faces inside match in pairs; those that do not are the box's surface.
      EXPECT_NEAR(open_area(model), 2 * (0.02 + 0.03 + 0.06), 1e-12);
      EXPECT_TRUE(find_flaws(model).empty());
      EXPECT_EQ(model.neighbours, neighbours_from_cells(model.cells, model.particle_count()));
    }
  }
}

TEST(TetrahedralBlock, JitterMovesInnerParticlesAndSlidesOuterOnes) {
  const Model still = make_tetrahedral_block({1, 1, 1}, 6, 6, 6, 0.0, 4);
  const Model moved = make_tetrahedral_block({1, 1, 1}, 6, 6, 6, 0.2, 4);
  EXPECT_EQ(still.cells, moved.cells);
  EXPECT_EQ(still.rest.front(), moved.rest.front());
  int shifted = 0;
  for (Index i = 0; i < still.particle_count(); ++i) {
    const Vec3 move = moved.rest[i] - still.rest[i];
    EXPECT_LE(move.norm(), 0.2 / 6 * (1 + 1e-12));
    shifted += move.norm() > 0.01 / 6;
  }
  EXPECT_GT(shifted, 300);  // all but the eight corners of 343, and the few that hardly move
  for (const char* side : {"x0", "x1"}) {
    for (const Index i : moved.group(side)) EXPECT_EQ(moved.rest[i].x(), side[1] == '0' ? 0.0 : 1.0);
  }
}

TEST(TetrahedralBlock, IsUnstructuredAndFollowsTheSeed) {
  const Model a = make_tetrahedral_block({1, 1, 1}, 6, 6, 6, 0.1, 1);
  EXPECT_EQ(a, make_tetrahedral_block({1, 1, 1}, 6, 6, 6, 0.1, 1));
  EXPECT_FALSE(a.cells == make_tetrahedral_block({1, 1, 1}, 6, 6, 6, 0.1, 2).cells);
  std::set<Index> valences;
  for (Index i = 0; i < a.particle_count(); ++i) {
    if (a.rest[i].minCoeff() > 0.05 && a.rest[i].maxCoeff() < 0.95) valences.insert(a.neighbours.size(i));
  }
  EXPECT_GT(valences.size(), 5u);  // a regular cut gives every inner particle the same
}

TEST(Jitter, MovesByUpToTheAmountAndFollowsTheSeed) {
  const Model still = make_block({0.06, 0.06, 0.06}, 6, 6, 6);
  Model moved = still, again = still, other = still;
  jitter(moved, 0.3, 9);
  jitter(again, 0.3, 9);
  jitter(other, 0.3, 10);
  EXPECT_EQ(moved, again);
  EXPECT_FALSE(moved.rest == other.rest);
  EXPECT_EQ(moved.neighbours, still.neighbours);
  double largest = 0.0;
  Vec3 mean = Vec3::Zero();
  for (Index i = 0; i < still.particle_count(); ++i) {
    largest = std::max(largest, (moved.rest[i] - still.rest[i]).norm());
    mean += (moved.rest[i] - still.rest[i]) / still.particle_count();
  }
  EXPECT_LE(largest, 0.3 * 0.01 * (1 + 1e-12));
  EXPECT_GT(largest, 0.9 * 0.3 * 0.01);
  EXPECT_LT(mean.norm(), 0.15 * 0.3 * 0.01);
  Model strip = make_strip(1, 1, 4, 4);
  jitter(strip, 0.3, 1);
  for (const Vec3& x : strip.rest) EXPECT_EQ(x.z(), 0.0);
}

}  // namespace
}  // namespace phymul
