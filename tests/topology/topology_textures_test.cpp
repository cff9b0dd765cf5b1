// SPDX-License-Identifier: MIT
//
// Packing: rectangles of texels, transposed lists.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

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
