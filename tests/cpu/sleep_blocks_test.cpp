// SPDX-License-Identifier: MIT
//
// Blocks of particles, and which of them depend on each other (SleepBlocks).
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <algorithm>

#include "cpu/packed/body_sleep.h"
#include "support/sleeping_scenes.h"

namespace phymul::test {
namespace {

/// Where the particles of a block move, forces change in the blocks it reaches and nowhere else.
TEST(SleepBlocks, ReachAsFarAsForcesChange) {
  const std::pair<const char*, Model> bodies[] = {
      {"lattice", wide_block()}, {"tetrahedra", long_tetrahedra()}, {"two materials", two_materials()}};
  for (const auto& [name, model] : bodies) {
    const TopologyTextures tables = build_topology(model, {});
    const auto body = cpu::make_packed_body(tables, 8);
    const cpu::SleepBlocks blocks = cpu::make_sleep_blocks(tables, *body);
    ASSERT_GT(blocks.count, 10) << name;
    std::vector<int> block_of(tables.rest.size());
    for (std::size_t place = 0; place < body->order.size(); ++place) {
      block_of[body->order[place]] = static_cast<int>(cpu::SleepBlocks::of_quad(body->quad_of(place)));
    }
    const VecList before = random_positions(model, 0.1, 5);
    VecList force_before(before.size()), force(before.size());
    elastic_forces(tables, before, force_before);
    bool some_unreached = false;
    for (int block = 0; block < blocks.count; ++block) {
      VecList after = before;
      for (std::size_t i = 0; i < after.size(); ++i) {
        if (block_of[i] == block) after[i] += 1e-3 * Vec3(1, -2, 3);
      }
      elastic_forces(tables, after, force);
      std::vector<bool> changes(static_cast<std::size_t>(blocks.count), false);
      for (std::size_t i = 0; i < after.size(); ++i) {
        if (force[i] != force_before[i]) changes[block_of[i]] = true;
      }
      for (int other = 0; other < blocks.count; ++other) {
        const bool reached = std::ranges::count(blocks.reach(block), other) == 1;
        EXPECT_TRUE(reached || !changes[other]) << name << ", from " << block << " to " << other;
        some_unreached = some_unreached || !reached;
      }
      EXPECT_EQ(std::ranges::count(blocks.reach(block), block), 1) << name;
    }
    EXPECT_TRUE(some_unreached) << name;
    EXPECT_EQ(blocks.first_further.back(), static_cast<int>(body->averages.further.size())) << name;
  }
}

/// A block that repeats itself is skipped when the buffers have changed places: its copies must be in both.
TEST(BodySleep, CopiesDisplacementsOfFurtherDomainsToBothBuffers) {
  const TopologyTextures tables = build_topology(two_materials(), {});
  const auto body = cpu::make_packed_body(tables, 8);
  ASSERT_FALSE(body->averages.further.empty());
  cpu::BodySleep sleep(tables, *body, 16);
  EXPECT_TRUE(sleep.none());
  sleep.begin({}, {});
  EXPECT_TRUE(sleep.all());
  cpu::Floats u(4 * static_cast<std::size_t>(body->averages.slots)), next_u(u.size(), -1.0f);
  for (std::size_t k = 0; k < u.size(); ++k) u[k] = static_cast<float>(k);
  sleep.copy_displacements(reinterpret_cast<char*>(u.data()), reinterpret_cast<char*>(next_u.data()));
  for (const auto& [own, other] : body->averages.further) {
    for (int a = 0; a < 4; ++a) {
      EXPECT_EQ(u[4 * other + a], static_cast<float>(4 * own + a));
      EXPECT_EQ(next_u[4 * other + a], static_cast<float>(4 * own + a));
    }
  }
  sleep.accept();
  sleep.begin({}, {});
  EXPECT_TRUE(sleep.none());  // nothing moved, and nothing else changed
}

TEST(SliceRanges, AreSharedOutOnce) {
  cpu::SliceRanges ranges;
  ranges.add(2, 5);
  ranges.add(5, 7);  // goes on
  ranges.add(9, 9);  // empty
  ranges.add(10, 14);
  ranges.add(12, 13);  // already there
  for (const int parts : {1, 2, 3, 5, 20}) {
    std::vector<int> seen;
    for (int part = 0; part < parts; ++part) {
      ranges.share(part, parts, [&](int first, int last) {
        ASSERT_LT(first, last);
        for (int slice = first; slice < last; ++slice) seen.push_back(slice);
      });
    }
    EXPECT_EQ(seen, (std::vector<int>{2, 3, 4, 5, 6, 10, 11, 12, 13})) << parts;
  }
  ranges.clear();
  ranges.share(0, 1, [](int, int) { FAIL(); });
}

}  // namespace
}  // namespace phymul::test
