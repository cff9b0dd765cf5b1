// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"
#include "topology/neighbourhoods.h"
#include "topology/topology_terms.h"

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

// Bodies at the edge of what tables can be made of: repeated, flat and inside-out cells, sparse particles, materials.

Model with_first_cell_twice() {
  Model model = make_tetrahedral_block({0.02, 0.02, 0.02}, 2, 2, 2, 0.1, 1);
  model.cells.push_back(model.cells.front());
  return model;
}

TEST(TopologyLimits, ARepeatedCellAddsVolume) {
  const auto domains = [](Model model) {
    set_material(model, soft_tissue());
    return build_topology(model).domains;
  };
  Model once = with_first_cell_twice();
  const std::vector<Index> cell = once.cells.front().particles;
  const std::vector<DomainTexel> t = domains(once);
  once.cells.pop_back();
  const std::vector<DomainTexel> s = domains(once);
  ASSERT_EQ(t.size(), s.size());
  for (std::size_t d = 0; d < t.size(); ++d) {
    const bool in_it = std::ranges::find(cell, t[d].particle) != cell.end();
    EXPECT_EQ(t[d].inverse_volume < 0.999 * s[d].inverse_volume, in_it) << "particle " << t[d].particle;
  }
}

TEST(TopologyLimits, PairsThatAllButCoincideAreNoBase) {
  for (const double scale : {1e-6, 1.0}) {
    const Vec3 x(0, scale, 0), a(scale, 0, 0);
    EXPECT_FALSE(has_plane(rest_pair(x, a, a + Vec3(1e-11 * scale, 0, 0))));
    EXPECT_TRUE(has_plane(rest_pair(x, a, a + Vec3(1e-6 * scale, 0, 0))));
  }
}

TEST(TopologyLimits, ParticlesOutsideTheMaterialTakeNoSprings) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  add_particle(model, {0.05, 0, 0}, {2, 5}, 3.0);
  set_material(model, soft_tissue());
  TopologyOptions options{.on_sparse = SparseParticle::springs};
  EXPECT_TRUE(refuses([&] { build_topology(model, options); },
                      "particle 27 is in no cell that has a material, and springs would need a stiffness"));
  options.on_sparse = SparseParticle::free;
  EXPECT_TRUE(build_topology(model, options).springs.empty());
}

TEST(CornerSimplices, FlatCornersAreLeftOutAndInsideOutOnesRefused) {
  Model flat = make_block({1, 1, 1}, 1, 1, 1);
  const std::vector<Index> ring = flat.cells[0].particles;
  // The ring's second corner lies on the line between its neighbours: no volume there, and none lost by it.
  flat.rest[ring[1]] = (flat.rest[ring[0]] + flat.rest[ring[2]]) / 2;
  flat.rest[ring[5]] = (flat.rest[ring[4]] + flat.rest[ring[6]]) / 2;
  const std::vector<CornerSimplex> corners = corner_simplices(flat, 0);
  EXPECT_EQ(corners.size(), 6u);
  double sum = 0.0;
  for (const CornerSimplex& corner : corners) sum += corner.share;
  EXPECT_NEAR(sum, cell_volume(flat, flat.cells[0]), 1e-12);
  // Past that line the corner looks inward while the cell as a whole does not.
  flat.rest[ring[1]] += 0.1 * (flat.rest[ring[3]] - flat.rest[ring[1]]);
  ASSERT_GT(cell_volume(flat, flat.cells[0]), 0.0);
  EXPECT_TRUE(refuses([&] { corner_simplices(flat, 0); }, "is inside out at rest"));
}

TEST(CornerSimplices, ACellWithoutVolumeIsRefused) {
  Model flat = make_tetrahedron(1.0);
  flat.rest[3] = flat.rest[0];
  EXPECT_TRUE(refuses([&] { corner_simplices(flat, 0); }, "is inside out at rest"));
}

// Packing: rectangles of texels, transposed lists.

TEST(FitTexture, NearSquareWithWidthAPowerOfTwo) {
  EXPECT_EQ(fit_texture(0, 16, "t"), (TextureShape{1, 1}));
  EXPECT_EQ(fit_texture(1, 16, "t"), (TextureShape{1, 1}));
  EXPECT_EQ(fit_texture(2, 16, "t"), (TextureShape{2, 1}));
  EXPECT_EQ(fit_texture(5, 16, "t"), (TextureShape{4, 2}));
  EXPECT_EQ(fit_texture(16, 16, "t"), (TextureShape{4, 4}));
  EXPECT_EQ(fit_texture(17, 16, "t"), (TextureShape{8, 3}));
  EXPECT_EQ(fit_texture(std::int64_t{16384} * 16384, 16384, "t"), (TextureShape{16384, 16384}));
  for (std::int64_t rows = 1; rows < 3000; ++rows) {
    const TextureShape shape = fit_texture(rows, 64, "t");
    EXPECT_GE(shape.texels(), rows);
    EXPECT_LT(shape.texels() - rows, shape.width);  // no empty line
    EXPECT_LE(std::max(shape.width, shape.height), 64);
    EXPECT_EQ(shape.width & (shape.width - 1), 0);
  }
}

TEST(FitTexture, LimitThatIsNoPowerOfTwoIsUsedInHeight) {
  EXPECT_EQ(fit_texture(4 * 7, 7, "t"), (TextureShape{4, 7}));
  EXPECT_NE(message_of([] { fit_texture(4 * 7 + 1, 7, "t"); }), "(no error)");
}

TEST(FitTexture, SaysWhichTableAndWhichSizes) {
  EXPECT_TRUE(refuses([] { fit_texture(257, 16, "neighbours"); }, "table of neighbours needs 257 rows",
                      "up to 16 texels a side hold 256"));
  EXPECT_TRUE(refuses([] { fit_texture(1, 0, "x"); }, "side of a texture is 0"));
}

// Every entry of `list` points back at its particle, and every place of `vertex` is listed once, in increasing order.
template <class Vertex>
void expect_transpose(const RaggedList& list, Index particles, std::size_t places, const Vertex& vertex) {
  ASSERT_EQ(list.rows(), particles);
  std::size_t listed = 0;
  for (Index i = 0; i < particles; ++i) {
    EXPECT_TRUE(std::is_sorted(list.begin(i), list.end(i)));
    for (const Index* entry = list.begin(i); entry != list.end(i); ++entry) {
      EXPECT_EQ(vertex(*entry), i);
      ++listed;
    }
  }
  std::size_t filled = 0;
  for (std::size_t p = 0; p < places; ++p) filled += vertex(static_cast<Index>(p)) >= 0 ? 1 : 0;
  EXPECT_EQ(listed, filled);
}

TEST(Textures, TransposedListsAreExactInverses) {
  for (const Body& body : bodies()) {
    TopologyOptions options{.volume_stiffness = body.name == "tetrahedron" || body.model.dimension == 2 ? 0.0 : 10.0};
    TopologyTextures t = build_topology(body.model, options);
    expect_transpose(t.base_of, t.particle_count, 3 * static_cast<std::size_t>(t.base_count),
                     [&](Index e) { return t.bases[e / 3].vertex[e % 3]; });
    for (Index i = 0; i < t.particle_count; ++i) {
      const IndexTexel& texel = t.index[i];
      for (Index r = texel.first_base; r < texel.first_base + texel.base_count; ++r) EXPECT_EQ(t.base_owner[r], i);
    }
    if (options.volume_stiffness > 0.0) {
      expect_transpose(t.volume_of, t.particle_count, 4 * t.volumes.size(),
                       [&](Index e) { return t.volumes[e / 4].vertex[e % 4]; });
    }
    options.reaction = Reaction::barycentric;
    t = build_topology(body.model, options);
    expect_transpose(t.neighbour_of, t.particle_count, static_cast<std::size_t>(t.neighbour_count),
                     [&](Index e) { return t.neighbours[e]; });
    for (Index i = 0; i < t.particle_count; ++i) {
      const IndexTexel& texel = t.index[i];
      for (Index r = texel.first_neighbour; r < texel.first_neighbour + texel.neighbour_count; ++r) {
        EXPECT_EQ(t.neighbour_owner[r], i);
      }
    }
    options.law = Law::springs;
    t = build_topology(body.model, options);
    expect_transpose(t.spring_of, t.particle_count, 2 * t.springs.size(),
                     [&](Index e) { return t.springs[e / 2].end[e % 2]; });
  }
}

TEST(Textures, OnlyWhatTheReactionNeedsIsFilled) {
  const Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  TopologyOptions options;
  for (Reaction reaction : {Reaction::full, Reaction::shared, Reaction::barycentric}) {
    options.reaction = reaction;
    const TopologyTextures t = build_topology(block, options);
    EXPECT_EQ(t.neighbour_of.entry.size(), static_cast<std::size_t>(t.neighbour_count));
    EXPECT_TRUE(t.base_of.entry.empty() && t.base_owner.empty());
  }
  for (Reaction reaction : {Reaction::averaged, Reaction::conservative}) {
    options.reaction = reaction;
    const TopologyTextures t = build_topology(block, options);
    EXPECT_EQ(t.base_of.entry.size(), 3 * static_cast<std::size_t>(t.base_count));
    EXPECT_TRUE(t.neighbour_of.entry.empty() && t.neighbour_owner.empty());
    EXPECT_TRUE(t.springs.empty() && t.volumes.empty() && t.domains.empty());
  }
}

}  // namespace
}  // namespace phymul::test
