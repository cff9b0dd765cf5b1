// SPDX-License-Identifier: MIT
//
// Trees that are walked without a stack, in the shapes that their users ask for.
#include "base/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

namespace phymul {
namespace {

constexpr std::array shapes{BoxTree::Shape{}, BoxTree::Shape{.leaf_size = 2, .halvings = 3}};

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
TEST(BoxTree, HoldsEveryItemOnceInATreeOfItsGroup) {
  const std::vector<Index> counts{1, 2, 3, 0, 16, 17, 500, 2049};
  const Places given(counts);
  for (const BoxTree::Shape& shape : shapes) {
    const BoxTree tree(given.places, given.group, static_cast<Index>(counts.size()), shape);
    ASSERT_EQ(tree.groups.size(), counts.size() + 1);
    std::vector<int> met(given.places.size(), 0);
    for (std::size_t g = 0; g < counts.size(); ++g) {
      Index items = 0;
      for (Index n = tree.groups[g]; n < tree.groups[g + 1]; ++n) {
        const BoxTree::Node& node = tree.nodes[n];
        if (!node.is_leaf) continue;
        EXPECT_LE(node.end - node.first, shape.leaf_size);
        EXPECT_EQ(node.next, n + 1);
        for (Index item = node.first; item < node.end; ++item) {
          EXPECT_EQ(given.group[tree.items[item]], static_cast<Index>(g));
          ++met[tree.items[item]];
          ++items;
        }
      }
      EXPECT_EQ(items, counts[g]);
    }
    EXPECT_TRUE(std::ranges::all_of(met, [](int times) { return times == 1; }));
  }
}

/// Skipping a node skips just its items.
TEST(BoxTree, SkipsFitTheChildren) {
  const Places given({700});
  for (const BoxTree::Shape& shape : shapes) {
    const BoxTree tree(given.places, given.group, 1, shape);
    for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
      const BoxTree::Node& node = tree.nodes[n];
      if (node.is_leaf) continue;
      Index children = 0, item = node.first;
      for (Index child = static_cast<Index>(n) + 1; child < node.next; child = tree.nodes[child].next) {
        EXPECT_EQ(tree.nodes[child].first, item);
        item = tree.nodes[child].end;
        ++children;
      }
      EXPECT_EQ(item, node.end);
      EXPECT_GT(children, 1);
      EXPECT_LE(children, 1 << shape.halvings);
    }
  }
}

/// A leaf is small beside the whole.
TEST(BoxTree, LeavesHoldWhatLiesTogether) {
  const Places given({2000});
  for (const BoxTree::Shape& shape : shapes) {
    const BoxTree tree(given.places, given.group, 1, shape);
    double sum = 0.0;
    int leaves = 0;
    for (const BoxTree::Node& node : tree.nodes) {
      if (!node.is_leaf || node.end - node.first < 2) continue;
      sum += (given.places[tree.items[node.first]] - given.places[tree.items[node.end - 1]]).norm();
      ++leaves;
    }
    EXPECT_LT(sum / leaves, 0.3);  // random pairs: 1.3
  }
}

}  // namespace
}  // namespace phymul
