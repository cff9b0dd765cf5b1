// SPDX-License-Identifier: MIT
//
// What the vector backend is made of: renumbering, simplices, triples, the pool of threads and who takes what of it.
#include <gtest/gtest.h>

#include <bit>
#include <numeric>

#include "base/thread_pool.h"
#include "cpu/packed/box_lattice.h"
#include "cpu/packed/cluster_claims.h"
#include "cpu/packed/hexahedra.h"
#include "cpu/packed/packed_body.h"
#include "cpu/packed/renumbering.h"
#include "cpu/packed/simplices.h"
#include "support/bodies.h"
#include "topology/locality_order.h"
#include "topology/neighbourhoods.h"

namespace phymul::test {
namespace {

TEST(Renumbering, PermutesForcesAndEnergy) {
  for (const Body& body : bodies()) {
    for (const Variant& variant : clustered_variants()) {
      if (!applies(variant, body)) continue;
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

TEST(Simplices, EveryTermIsTakenOnce) {
  Model model = make_tetrahedral_block({0.03, 0.02, 0.02}, 3, 2, 2, 0.2, 5);
  set_material(model, soft_tissue());
  const TopologyTextures tables = build_topology(model);
  const cpu::Simplices simplices = cpu::find_simplices(tables);
  EXPECT_EQ(simplices.all.size(), model.cells.size());
  std::vector<int> taken(static_cast<std::size_t>(tables.base_count), 0);
  for (const cpu::Simplex& simplex : simplices.all) {
    EXPECT_NE(simplex.cell, none);
    for (int k = 0; k < 4; ++k) {
      ASSERT_NE(simplex.base[k], none);
      EXPECT_EQ(tables.base_owner[simplex.base[k]], simplex.vertex[k]);
      ++taken[simplex.base[k]];
    }
  }
  for (const int times : taken) EXPECT_EQ(times, 1);
}

TEST(Hexahedra, LatticesHaveOneShapeAndBentBodiesNone) {
  const auto found = [](Model model) {
    set_material(model, soft_tissue());
    const TopologyTextures tables = build_topology(model, {.cell_average = 0.9});
    return cpu::find_hexahedra(tables, cpu::find_simplices(tables));
  };
  Model block = make_block({0.06, 0.06, 0.06}, 6, 6, 6);
  EXPECT_EQ(found(block).all.size(), 216u);
  EXPECT_EQ(found(block).shapes.size(), 1u);
  block.rest[0].x() -= 0.002;
  EXPECT_EQ(found(block).all.size(), 215u);
  jitter(block, 0.1, 3);
  EXPECT_LE(found(block).all.size(), 1u);
}

/// Boxes of a block in which cells at x < `border` have another material.
cpu::BoxLattice boxes_of(Model model, double border, std::size_t& others) {
  set_material(model, soft_tissue());
  std::vector<Index> left;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (model.rest[i].x() < border) left.push_back(i);
  }
  if (border > 0.0) {
    model.add_group("left", left);
    set_material(model, {50e3, 0.3, 1000.0}, "left");
  }
  const TopologyTextures tables = build_topology(model, {.cell_average = 0.9});
  cpu::Hexahedra hexahedra = cpu::find_hexahedra(tables, cpu::find_simplices(tables));
  cpu::BoxLattice lattice = cpu::take_boxes(hexahedra);
  others = hexahedra.all.size();
  for (const cpu::Star& star : lattice.stars) {
    for (int s = 0; s < 6; ++s) {
      if (star.spoke[s] == none) continue;
      Vec3 edge = tables.rest[star.spoke[s]] - tables.rest[star.centre];
      EXPECT_GT((s % 2 == 0 ? -1.0 : 1.0) * edge[s / 2], 0.009);
      edge[s / 2] = 0.0;
      EXPECT_LT(edge.norm(), 1e-9);
    }
  }
  return lattice;
}

TEST(BoxLattice, EveryCornerOfABoxIsAnOctantOfOneStar) {
  const auto octants = [](const cpu::BoxLattice& lattice) {
    int sum = 0;
    for (const cpu::Star& star : lattice.stars) sum += std::popcount(static_cast<unsigned>(star.octants));
    return sum;
  };
  Model block = make_block({0.12, 0.06, 0.06}, 12, 6, 6);
  std::size_t others = 0;
  const cpu::BoxLattice one = boxes_of(block, 0.0, others);
  EXPECT_EQ(one.boxes.size(), 432u);
  EXPECT_EQ(one.stars.size(), 637u);
  EXPECT_EQ(octants(one), 8 * 432);
  EXPECT_EQ(others, 0u);
  const cpu::BoxLattice two = boxes_of(block, 0.065, others);
  EXPECT_EQ(two.shapes.size(), 2u);
  EXPECT_EQ(two.stars.size(), 637u + 49u) << "particles between two materials have two stars";
  EXPECT_EQ(octants(two), 8 * 432);
  block.rest[0].x() -= 0.002;
  EXPECT_EQ(octants(boxes_of(block, 0.0, others)), 8 * 431);
  // A body of equal cells that are no boxes keeps them.
  for (Vec3& p : block.rest) p = Vec3(p.x() + 0.3 * p.y(), p.y(), p.z());
  EXPECT_TRUE(boxes_of(block, 0.0, others).stars.empty());
  EXPECT_GT(others, 400u);
}

/// Lanes of grids, and cells and particles that are left to be gathered.
struct GridShare {
  long octants = 0, vectors = 0, gathered = 0;
};

GridShare grid_share(Model model) {
  set_material(model, soft_tissue());
  const TopologyTextures tables = build_topology(model, {.cell_average = 0.9});
  const auto body = cpu::make_packed_body(tables, 8);
  GridShare share;
  for (const cpu::Cluster& cluster : body->clusters) {
    const cpu::simd::Grid& grid = cluster.job.grid;
    share.vectors += grid.count;
    share.gathered += cluster.job.stars.count + cluster.job.boxes.count + cluster.job.hexahedra.count;
    for (int k = 0; k < 8 * grid.count; ++k) {
      share.octants += std::popcount(static_cast<unsigned>(grid.octants[k]));
    }
    const int reach = grid.stride[0] + grid.stride[1] + grid.stride[2];
    for (int r = 0; r < grid.count; ++r) {
      EXPECT_LE(grid.rows[r].node + 8 + reach, grid.nodes + grid.margin);
      EXPECT_EQ(grid.whole > r,
                std::all_of(grid.octants + 8 * r, grid.octants + 8 * (r + 1), [](int o) { return o == 0xff; }));
    }
  }
  return share;
}

TEST(Grid, ALatticeIsTakenByTheNode) {
  for (const auto& [x, y, z] : {std::array{8, 8, 32}, std::array{20, 20, 20}, std::array{60, 5, 5}}) {
    const GridShare share = grid_share(make_block({0.01 * x, 0.01 * y, 0.01 * z}, x, y, z));
    EXPECT_EQ(share.octants, 8L * x * y * z);
    EXPECT_EQ(share.gathered, 0);
    EXPECT_LE(share.vectors * 8, 1.1 * (x + 1) * (y + 1) * (z + 1)) << "idle lanes";
  }
}

TEST(Grid, WhatStandsOffTheLatticeIsGathered) {
  Model model = make_block({0.2, 0.2, 0.2}, 20, 20, 20);
  model.rest[5000] += Vec3(0.002, 0.0, 0.0);  // inside: eight cells are no boxes
  const GridShare share = grid_share(model);
  EXPECT_EQ(share.octants, 8L * (8000 - 8));
  EXPECT_EQ(share.gathered, 0);
  for (Vec3& p : model.rest) p = Vec3(p.x() + 0.3 * p.y(), p.y(), p.z());
  EXPECT_EQ(grid_share(model).vectors, 0);
}

TEST(Neighbourhoods, TriplesAreCountedInOrder) {
  Index row = 0;
  for (Index j = 0; j < 7; ++j) {
    for (Index k = j + 1; k < 7; ++k) {
      for (Index l = k + 1; l < 7; ++l) EXPECT_EQ(cpu::triple_row(7, j, k, l), row++);
    }
  }
  EXPECT_EQ(row, 35);
  const Model model = make_block({0.03, 0.03, 0.03}, 3, 3, 3);
  const TopologyTextures all = build_topology(model, {.reaction = Reaction::shared, .bases = BaseSelection::all});
  EXPECT_TRUE(cpu::is_enumerable(all, 6));
  EXPECT_FALSE(cpu::is_enumerable(all, 5));
  EXPECT_FALSE(cpu::is_enumerable(build_topology(model), 6)) << "conservative";
}

TEST(ThreadPool, RunsEveryPartOnceEachTime) {
  for (const int parts : {1, 2, 5}) {
    cpu::ThreadPool pool(parts);
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
    cpu::ThreadPool pool(parts);
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

}  // namespace
}  // namespace phymul::test
