// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <numeric>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr std::array selections{BaseSelection::all, BaseSelection::thresholded};

TEST(Topology, NeighboursAreTheModels) {
  const Model block = make_block({3, 2, 2}, 3, 2, 2, 26);
  const TopologyTextures t = build_topology(block);
  EXPECT_TRUE(std::equal(block.neighbours.entry.begin(), block.neighbours.entry.end(), t.neighbours.begin()));
}

TEST(Topology, StiffnessInNewtonsPerMetreIsTheModels) {
  Model block = make_block({3, 2, 2}, 3, 2, 2);
  for (Index i = 0; i < block.particle_count(); ++i) block.stiffness[i] = i;  // 0 among them
  for (BaseSelection bases : selections) {
    EXPECT_EQ(build_topology(block, {.bases = bases}).stiffness, block.stiffness);
  }
}

TEST(Topology, TablesFollowTheSizeOfTheBody) {
  const TopologyTextures small = build_topology(make_block({3e-6, 2e-6, 2e-6}, 3, 2, 2, 26));
  const TopologyTextures large = build_topology(make_block({3e3, 2e3, 2e3}, 3, 2, 2, 26));
  ASSERT_EQ(small.base_count, large.base_count);
  for (Index r = 0; r < small.neighbour_count; ++r) EXPECT_NEAR(small.alpha[r], large.alpha[r], 1e-12);
  for (Index r = 0; r < small.base_count; ++r) EXPECT_NEAR(small.bases[r].beta * 1e9, large.bases[r].beta, 1e-9 * 3e3);
}

TEST(Topology, SpringsAreNeighbouringPairsOnce) {
  Model block = make_block({3, 2, 2}, 3, 2, 2, 6);
  for (Index i = 0; i < block.particle_count(); ++i) block.stiffness[i] = 1.0 + i;
  const TopologyOptions options{.law = Law::springs};
  const TopologyTextures t = build_topology(block, options);
  EXPECT_EQ(t.springs.size(), 3u * 9 + 4u * 2 * 3 * 2);  // edges along x, then along y and z
  EXPECT_EQ(t.base_count, 0);
  EXPECT_EQ(t.neighbour_count, 0);  // bases alone read them
  for (const SpringTexel& spring : t.springs) {
    EXPECT_LT(spring.end[0], spring.end[1]);
    EXPECT_DOUBLE_EQ(spring.rest_length, 1.0);
    EXPECT_DOUBLE_EQ(spring.stiffness, 1.0 + (spring.end[0] + spring.end[1]) / 2.0);
  }
  // One direction is enough.
  Model chain = make_tetrahedron(1.0);
  chain.neighbours = {};
  const std::vector<Index> first{1, 2, 3};
  chain.neighbours.push_row(first.begin(), first.end());
  for (int i = 1; i < 4; ++i) chain.neighbours.push_row(first.end(), first.end());
  EXPECT_EQ(build_topology(chain, options).springs.size(), 3u);
}

TEST(Topology, SparseParticlesAreNamedBoundOrFree) {
  Model model = make_block({2, 2, 2}, 2, 2, 2, 6);
  add_particle(model, {5, 0, 0}, {0, 1}, 3.0);
  TopologyOptions options;
  EXPECT_TRUE(
      refuses([&] { build_topology(model, options); }, "particle 27 has no base: one takes 3 neighbours", "on_sparse"));
  change_extras(model, [](FileExtras& extras) {
    extras.particle_index.resize(28);
    std::iota(extras.particle_index.begin(), extras.particle_index.end(), 1000);
  });
  EXPECT_TRUE(refuses([&] { build_topology(model, options); }, "particle 1027 has"));

  options.on_sparse = SparseParticle::free;
  EXPECT_TRUE(build_topology(model, options).springs.empty());
  options.on_sparse = SparseParticle::springs;
  const TopologyTextures t = build_topology(model, options);
  ASSERT_EQ(t.springs.size(), 2u);
  EXPECT_EQ(t.springs[1].end, (std::array<Index, 2>{27, 1}));
  EXPECT_DOUBLE_EQ(t.springs[1].rest_length, 4.0);
  EXPECT_DOUBLE_EQ(t.springs[1].stiffness, 3.0);
  EXPECT_EQ(t.spring_of.size(27), 2);

  for (double& mass : model.mass) mass = 1.0;
  for (Vec3& p : model.rest) p.y() = p.z() = 0.0;  // all on one line
  options.on_sparse = SparseParticle::error;
  EXPECT_TRUE(refuses([&] { build_topology(model, options); },
                      "particles 1000, 1001, 1002, 1003, 1004 and 23 more have no base"));
}

TEST(Topology, VolumeTermsStandForTheWholeBody) {
  struct Case {
    Model model;
    double volume;
    std::size_t terms;
  };
  for (const Case& it :
       {Case{make_block({3, 2, 2}, 3, 2, 2), 12.0, 96},
        Case{make_tetrahedral_block({3, 2, 2}, 3, 2, 2, 0.2, 1), 12.0, 0}, Case{make_strip(4, 2, 4, 2), 8.0, 32}}) {
    const TopologyTextures t = build_topology(it.model, {.volume_stiffness = 50.0});
    double sum = 0.0;
    for (const VolumeTexel& term : t.volumes) {
      sum += term.stiffness;
      const auto& v = term.vertex;
      const Vec3 a = t.rest[v[1]] - t.rest[v[0]], b = t.rest[v[2]] - t.rest[v[0]];
      const double volume = v[3] == none ? a.cross(b).z() / 2 : a.cross(b).dot(t.rest[v[3]] - t.rest[v[0]]) / 6;
      EXPECT_NEAR(volume * term.inverse_rest_volume, 1.0, 1e-12);
    }
    EXPECT_NEAR(sum, 50.0 * it.volume, 1e-9);
    if (it.terms > 0) {
      EXPECT_EQ(t.volumes.size(), it.terms);
    } else {
      EXPECT_EQ(t.volumes.size(), it.model.cells.size());
    }
  }
}

TEST(Topology, ClockwisePlaneCellsAreTurnedOver) {
  Model strip = make_strip(4, 2, 4, 2);
  for (Cell& cell : strip.cells) std::reverse(cell.particles.begin(), cell.particles.end());
  const TopologyOptions options{.volume_stiffness = 1.0};
  for (const VolumeTexel& term : build_topology(strip, options).volumes) EXPECT_GT(term.inverse_rest_volume, 0.0);
}

TEST(Topology, OptionsOutOfRangeAreRefusedByName) {
  const Model block = make_block({1, 1, 1}, 1, 1, 1);
  const auto refuse = [&](auto&& set) {
    TopologyOptions options;
    set(options);
    return message_of([&] { build_topology(block, options); });
  };
  EXPECT_TRUE(says(refuse([](TopologyOptions& o) { o.min_quality = 1.5; }), "min_quality is 1.5"));
  EXPECT_TRUE(says(refuse([](TopologyOptions& o) { o.max_barycentric = 0; }), "max_barycentric is 0"));
  EXPECT_TRUE(says(refuse([](TopologyOptions& o) { o.volume_stiffness = NAN; }), "volume_stiffness is nan"));
  Model wire = make_tetrahedron(1.0);
  wire.cells.clear();
  wire.components.clear();
  EXPECT_TRUE(refuses([&] { build_topology(wire, {.volume_stiffness = 1.0}); }, "a volume term needs tetrahedra"));
}

}  // namespace
}  // namespace phymul::test
