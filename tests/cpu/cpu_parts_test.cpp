// SPDX-License-Identifier: MIT
//
// What the vector backend is made of: renumbering, triples, the pool of threads and who takes what of it.
#include <phymul/elasticity.h>

#include <gtest/gtest.h>
#include <algorithm>

#include "base/thread_pool.h"
#include "cpu/packed/body_sleep.h"
#include "cpu/packed/force_passes.h"
#include "cpu/packed/packed_body.h"
#include "support/bodies.h"
#include "support/run_scenes.h"
#include "topology/locality_order.h"
#include "topology/neighbourhoods.h"

namespace phymul::test {
namespace {

TEST(Renumbering, PermutesForcesAndEnergy) {
  for (const Body& body : bodies()) {
    for (const Variant& variant : clustered_variants()) {
      const Model model = prepared(variant, body);
      const TopologyTextures tables = build_topology(model, variant.options);
      const Index n = tables.particle_count;
      std::vector<Index> work(static_cast<std::size_t>(n));
      for (Index i = 0; i < n; ++i) work[i] = i % 5;
      const std::vector<Index> order = locality_order(tables.rest, work, 16);
      std::vector<Index> sorted = order;
      std::ranges::sort(sorted);
      for (Index i = 0; i < n; ++i) ASSERT_EQ(sorted[i], i);
      const TopologyTextures other = cpu::renumbered(tables, order);
      const VecList x = random_positions(model, 0.1, 3);
      VecList moved(x.size()), force(x.size()), other_force(x.size());
      for (Index i = 0; i < n; ++i) moved[i] = x[order[i]];
      elastic_forces(tables, x, force);
      elastic_forces(other, moved, other_force);
      const double scale = largest_norm(force);
      for (Index i = 0; i < n; ++i) {
        ASSERT_LE((other_force[i] - force[order[i]]).norm(), 1e-12 * scale) << body.name << ", " << variant.name;
      }
      EXPECT_NEAR(elastic_energy(other, moved), elastic_energy(tables, x), 1e-12 * elastic_energy(tables, x));
    }
  }
}

TEST(Renumbering, PutsNeighboursNearEachOtherAndWorkInOrder) {
  const Model model = make_block({0.15, 0.15, 0.15}, 15, 15, 15);
  std::vector<Index> work;
  for (Index i = 0; i < model.particle_count(); ++i) work.push_back(model.neighbours.size(i));
  const std::vector<Index> order = locality_order(model.rest, work, 256);
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (i % 256 == 0) continue;
    ASSERT_GE(work[order[i - 1]], work[order[i]]);
  }
  for (std::size_t first = 0; first < order.size(); first += 256) {
    Vec3 low = model.rest[order[first]], high = low;
    for (std::size_t i = first; i < std::min(first + 256, order.size()); ++i) {
      low = low.cwiseMin(model.rest[order[i]]);
      high = high.cwiseMax(model.rest[order[i]]);
    }
    EXPECT_LE((high - low).prod(), 600.0 * 1e-6);  // 256 of 1e-6 m^3 each, in no thin slice
  }
}

TEST(Neighbourhoods, TriplesAreCountedInOrder) {
  Index row = 0;
  for (Index j = 0; j < 7; ++j) {
    for (Index k = j + 1; k < 7; ++k) {
      for (Index l = k + 1; l < 7; ++l) EXPECT_EQ(triple_row(7, j, k, l), row++);
    }
  }
  EXPECT_EQ(row, 35);
  const Model model = make_block({0.03, 0.03, 0.03}, 3, 3, 3);
  const TopologyTextures all = build_topology(model, {.reaction = Reaction::shared, .bases = BaseSelection::all});
  EXPECT_TRUE(is_enumerable(all, 6));
  EXPECT_FALSE(is_enumerable(all, 5));
  EXPECT_FALSE(is_enumerable(build_topology(model), 6)) << "conservative";
}

TEST(ThreadPool, RunsEveryPartOnceEachTime) {
  for (const int parts : {1, 2, 5}) {
    ThreadPool pool(parts);
    EXPECT_EQ(pool.parts(), parts);
    std::vector<long> sum(static_cast<std::size_t>(parts), 0);
    for (long round = 1; round <= 2000; ++round) {
      pool.run([&](int part, int of) { sum[static_cast<std::size_t>(part)] += round * of; });
    }
    for (const long s : sum) EXPECT_EQ(s, 2001000L * parts);
  }
}

/// Clusters of a body that costs so much each.
cpu::PackedBody body_of_clusters(const std::vector<double>& costs) {
  cpu::PackedBody body;
  body.clusters.resize(costs.size());
  for (std::size_t c = 0; c < costs.size(); ++c) body.clusters[c].cost = costs[c];
  return body;
}

std::vector<int> all_for(cpu::ClusterClaims& claims, int part) {
  std::vector<int> taken;
  for (int c = claims.take(part); c >= 0; c = claims.take(part)) taken.push_back(c);
  return taken;
}

TEST(ClusterClaims, AreOfEqualCost) {
  cpu::ClusterClaims claims(body_of_clusters({3, 1, 1, 1, 2, 2, 2}), 2);
  for (int step = 0; step < 2; ++step) {
    claims.begin();
    // Both take in turns: neither finds more than one cluster left with the other.
    std::vector<int> first, second;
    for (int k = 0; k < 4; ++k) {
      first.push_back(claims.take(0));
      second.push_back(claims.take(1));
    }
    EXPECT_EQ(first, (std::vector<int>{0, 1, 2, 3}));
    EXPECT_EQ(second, (std::vector<int>{4, 5, 6, -1}));
    EXPECT_EQ(claims.take(0), -1);
  }
}

TEST(ClusterClaims, OfALatePartAreTakenFromItsEnd) {
  cpu::ClusterClaims claims(body_of_clusters(std::vector<double>(8, 1.0)), 2);
  claims.begin();
  EXPECT_EQ(claims.take(1), 4);
  EXPECT_EQ(all_for(claims, 0), (std::vector<int>{0, 1, 2, 3, 7, 6})) << "the last one is left to its part";
  EXPECT_EQ(all_for(claims, 1), (std::vector<int>{5}));
}

TEST(ClusterClaims, GiveEveryClusterOnceWhoeverIsFaster) {
  for (const int parts : {1, 2, 7}) {
    ThreadPool pool(parts);
    cpu::ClusterClaims claims(body_of_clusters(std::vector<double>(40, 1.0)), pool.parts());
    std::vector<int> times(40, 0);
    for (int step = 1; step <= 500; ++step) {
      claims.begin();
      pool.run([&](int part, int) {
        for (int c = claims.take(part); c >= 0; c = claims.take(part)) ++times[static_cast<std::size_t>(c)];
      });
      ASSERT_EQ(times, std::vector<int>(40, step)) << parts << " parts";
    }
  }
}

// Blocks of particles, and which of them depend on each other (SleepBlocks).

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
