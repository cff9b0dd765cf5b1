// SPDX-License-Identifier: MIT
//
// Trees that a device walks without a stack.
#include "device/box_forest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace phymul {
namespace {

struct Places {
  explicit Places(const std::vector<Index>& counts) {
    std::mt19937 bits(7);
    std::uniform_real_distribution<double> along(-1.0, 1.0);
    for (std::size_t g = 0; g < counts.size(); ++g) {
      for (Index k = 0; k < counts[g]; ++k) {
        places.push_back({along(bits), along(bits), along(bits)});
        group.push_back(static_cast<Index>(g));
      }
    }
  }
  VecList places;
  std::vector<Index> group;
};

/// Whoever enters every node meets every item of its group once, and comes out at the group's end.
TEST(BoxForest, HoldsEveryItemOnceInATreeOfItsGroup) {
  const std::vector<Index> counts{1, 2, 3, 0, 16, 17, 500, 2049};
  const Places given(counts);
  const BoxForest forest(given.places, given.group, static_cast<Index>(counts.size()));
  ASSERT_EQ(forest.roots.size(), counts.size());
  std::vector<int> met(given.places.size(), 0);
  for (std::size_t g = 0; g < counts.size(); ++g) {
    Index items = 0;
    for (int n = forest.roots[g][0]; n < forest.roots[g][1]; ++n) {
      const Int4& node = forest.nodes[n];
      if (node[3] != 1) continue;
      EXPECT_LE(node[1] - node[0], BoxForest::items_a_leaf);
      EXPECT_EQ(node[2], n + 1);
      for (int entry = node[0]; entry < node[1]; ++entry) {
        EXPECT_EQ(given.group[forest.items[entry]], static_cast<Index>(g));
        ++met[forest.items[entry]];
        ++items;
      }
    }
    EXPECT_EQ(items, counts[g]);
  }
  EXPECT_TRUE(std::ranges::all_of(met, [](int times) { return times == 1; }));
}

/// A level needs those below it and nothing else, and skipping a node skips just its items.
TEST(BoxForest, LevelsAndSkipsFitTheChildren) {
  const Places given({700});
  const BoxForest forest(given.places, given.group, 1);
  Index highest = 0;
  for (std::size_t n = 0; n < forest.nodes.size(); ++n) {
    const Int4& node = forest.nodes[n];
    highest = std::max(highest, Index{node[3]});
    if (node[3] == 1) continue;
    Index children = 0, level = 0;
    int entry = node[0];
    for (int child = static_cast<int>(n) + 1; child < node[2]; child = forest.nodes[child][2]) {
      EXPECT_EQ(forest.nodes[child][0], entry);
      entry = forest.nodes[child][1];
      level = std::max(level, Index{forest.nodes[child][3]});
      ++children;
    }
    EXPECT_EQ(entry, node[1]);
    EXPECT_EQ(node[3], level + 1);
    EXPECT_GT(children, 1);
    EXPECT_LE(children, BoxForest::children);
  }
  EXPECT_EQ(forest.levels, highest);
  EXPECT_LE(highest, 4);  // 2 * 8^3 items
}

/// Along a curve through space: a leaf is small beside the whole.
TEST(BoxForest, LeavesHoldWhatLiesTogether) {
  const Places given({2000});
  const BoxForest forest(given.places, given.group, 1);
  double sum = 0.0;
  int leaves = 0;
  for (const Int4& node : forest.nodes) {
    if (node[3] != 1 || node[1] - node[0] < 2) continue;
    sum += (given.places[forest.items[node[0]]] - given.places[forest.items[node[0] + 1]]).norm();
    ++leaves;
  }
  EXPECT_LT(sum / leaves, 0.3);  // random pairs: 1.3
}

}  // namespace
}  // namespace phymul
