// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <tuple>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr std::array selections{BaseSelection::all, BaseSelection::thresholded};

// P*_i from the tables alone; once by alpha, once base by base.
Vec3 attractor_by_alpha(const TopologyTextures& t, const VecList& x, Index i) {
  const IndexTexel& texel = t.index[i];
  Vec3 p = Vec3::Zero();
  for (Index r = texel.first_neighbour; r < texel.first_neighbour + texel.neighbour_count; ++r) {
    p += t.alpha[r] * x[t.neighbours[r]];
  }
  for (Index r = texel.first_base; r < texel.first_base + texel.base_count; ++r) {
    const auto& [a, b, c] = t.bases[r].vertex;
    const Vec3 ab = x[b] - x[a];
    const Vec3 w = c == none ? Vec3(-ab.y(), ab.x(), 0) : Vec3(ab.cross(x[c] - x[a]));
    p += t.weight[r] * t.bases[r].beta * w.normalized();
  }
  return p;
}

TEST(Topology, AttractorOfTheRestShapeIsTheRestShape) {
  for (const Body& body : bodies()) {
    for (BaseSelection bases : selections) {
      TopologyOptions options;
      options.bases = bases;
      options.on_sparse = SparseParticle::free;
      const TopologyTextures t = build_topology(body.model, options);
      Index seen = 0;
      for (Index i = 0; i < t.particle_count; ++i) {
        if (t.index[i].base_count == 0) continue;
        ++seen;
        EXPECT_LT((attractor_by_alpha(t, t.rest, i) - t.rest[i]).norm(), 1e-12 * body_size(body.model))
            << body.name << " particle " << i << " selection " << static_cast<int>(bases);
      }
      EXPECT_GT(seen, 0) << body.name;
    }
  }
}

TEST(Topology, AlphaAndWeightsSumToOneAndLambdaToo) {
  for (const Body& body : bodies()) {
    for (BaseSelection bases : selections) {
      TopologyOptions options;
      options.bases = bases;
      options.on_sparse = SparseParticle::free;
      const TopologyTextures t = build_topology(body.model, options);
      for (Index i = 0; i < t.particle_count; ++i) {
        const IndexTexel& texel = t.index[i];
        if (texel.base_count == 0) continue;
        const double* alpha = t.alpha.data() + texel.first_neighbour;
        const double* weight = t.weight.data() + texel.first_base;
        EXPECT_NEAR(std::accumulate(alpha, alpha + texel.neighbour_count, 0.0), 1.0, 1e-12);
        EXPECT_NEAR(std::accumulate(weight, weight + texel.base_count, 0.0), 1.0, 1e-12);
      }
      for (const auto& lambda : t.lambda) EXPECT_NEAR(lambda[0] + lambda[1] + lambda[2], 1.0, 1e-12);
    }
  }
}

TEST(Topology, NeighboursAreTheModels) {
  const Model block = make_block({3, 2, 2}, 3, 2, 2, 26);
  const TopologyTextures t = build_topology(block);
  EXPECT_TRUE(std::equal(block.neighbours.entry.begin(), block.neighbours.entry.end(), t.neighbours.begin()));
}

TEST(Topology, StiffnessInNewtonsPerMetreIsTheModels) {
  Model block = make_block({3, 2, 2}, 3, 2, 2);
  for (Index i = 0; i < block.particle_count(); ++i) block.stiffness[i] = i;  // 0 among them
  for (BaseSelection bases : selections) {
    TopologyOptions options;
    options.bases = bases;
    EXPECT_EQ(build_topology(block, options).stiffness, block.stiffness);
  }
}

// The tables as sets of rows that do not know particle numbers, only places: for comparing renumbered bodies.
using PlacedBase = std::tuple<double, double, double, double, double>;
std::multimap<PlacedBase, double> placed_alpha(const TopologyTextures& t, const std::vector<Index>& original) {
  std::multimap<PlacedBase, double> rows;
  for (Index i = 0; i < t.particle_count; ++i) {
    const IndexTexel& texel = t.index[i];
    for (Index r = texel.first_neighbour; r < texel.first_neighbour + texel.neighbour_count; ++r) {
      rows.emplace(PlacedBase{original[i], original[t.neighbours[r]], t.stiffness[i], t.mass[i], texel.base_count},
                   t.alpha[r]);
    }
  }
  return rows;
}

TEST(Topology, RenumberingParticlesRenumbersTheTables) {
  const Model model = jittered_block();
  const Index n = model.particle_count();
  std::vector<Index> original(static_cast<std::size_t>(n)), renumbered(original.size());
  for (Index i = 0; i < n; ++i) original[i] = (i * 29) % n;  // 29 and n share no factor
  for (Index i = 0; i < n; ++i) renumbered[original[i]] = i;
  Model turned = model;
  turned.neighbours = {};
  for (Index i = 0; i < n; ++i) {
    turned.rest[i] = model.rest[original[i]];
    std::vector<Index> row;
    for (const Index* j = model.neighbours.begin(original[i]); j != model.neighbours.end(original[i]); ++j) {
      row.push_back(renumbered[*j]);
    }
    turned.neighbours.push_row(row.begin(), row.end());
  }
  for (Cell& cell : turned.cells) {
    for (Index& p : cell.particles) p = renumbered[p];
  }
  std::vector<Index> identity(original.size());
  std::iota(identity.begin(), identity.end(), 0);
  for (BaseSelection bases : selections) {
    TopologyOptions options;
    options.bases = bases;
    const auto before = placed_alpha(build_topology(model, options), identity);
    const auto after = placed_alpha(build_topology(turned, options), original);
    ASSERT_EQ(before.size(), after.size());
    for (auto a = before.begin(), b = after.begin(); a != before.end(); ++a, ++b) {
      EXPECT_EQ(a->first, b->first);
      EXPECT_NEAR(a->second, b->second, 1e-10);
    }
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
  TopologyOptions options;
  options.law = Law::springs;
  const TopologyTextures t = build_topology(block, options);
  EXPECT_EQ(t.springs.size(), 3u * 9 + 4u * 2 * 3 * 2);  // edges along x, then along y and z
  EXPECT_EQ(t.base_count, 0);
  EXPECT_EQ(t.neighbour_count, static_cast<Index>(block.neighbours.entry.size()));
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
  model.rest.push_back({5, 0, 0});
  model.mass.push_back(1.0);
  model.stiffness.push_back(3.0);
  const std::vector<Index> two{0, 1};
  model.neighbours.push_row(two.begin(), two.end());
  TopologyOptions options;
  const std::string text = message_of([&] { build_topology(model, options); });
  EXPECT_TRUE(says(text, "particle 27 has no base: one takes 3 neighbours"));
  EXPECT_TRUE(says(text, "on_sparse"));
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
    TopologyOptions options;
    options.volume_stiffness = 50.0;
    const TopologyTextures t = build_topology(it.model, options);
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
  TopologyOptions options;
  options.volume_stiffness = 1.0;
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
  EXPECT_TRUE(says(refuse([](TopologyOptions& o) { o.max_texture_size = 0; }), "max_texture_size is 0"));
  Model wire = make_tetrahedron(1.0);
  wire.cells.clear();
  wire.components.clear();
  TopologyOptions options;
  options.volume_stiffness = 1.0;
  EXPECT_TRUE(refuses([&] { build_topology(wire, options); }, "a volume term needs tetrahedra"));
}

}  // namespace
}  // namespace phymul::test
