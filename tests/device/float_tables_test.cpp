// SPDX-License-Identifier: MIT
//
// Packing of the constants for float backends.
#include "device/float_tables.h"

#include "device/float_range.h"

#include <gtest/gtest.h>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

float as_float(std::int32_t bits) {
  return std::bit_cast<float>(bits);
}

Vec3 vector_of(const Float4& texel) {
  return {texel[0], texel[1], texel[2]};
}

TopologyTextures built(const Model& model, Reaction reaction, BaseSelection bases = BaseSelection::thresholded) {
  TopologyOptions options;
  options.reaction = reaction;
  options.bases = bases;
  return build_topology(model, options);
}

TEST(FloatTables, BasesAreEdgesRoundedOnce) {
  Model model = jittered_block();
  for (Vec3& p : model.rest) p += Vec3(1000, -2000, 500);
  const TopologyTextures t = built(model, Reaction::conservative);
  const FloatTables f = pack_floats(t);
  ASSERT_EQ(f.base.size(), static_cast<std::size_t>(t.base_count));
  for (Index row = 0; row < t.base_count; ++row) {
    const auto [a, b, c] = t.bases[row].vertex;
    EXPECT_EQ(f.base[row], (Int4{a, b, c, bits_of(static_cast<float>(t.bases[row].beta))}));
    EXPECT_EQ(vector_of(f.base_e1[row]), (t.rest[b] - t.rest[a]).cast<float>().cast<double>());
    EXPECT_EQ(vector_of(f.base_e2[row]), (t.rest[c] - t.rest[a]).cast<float>().cast<double>());
    EXPECT_EQ(f.base_e1[row][3], static_cast<float>(t.lambda[row][1]));
    EXPECT_EQ(f.base_e2[row][3], static_cast<float>(t.lambda[row][2]));
    const Index owner = t.base_owner[row];
    EXPECT_EQ(f.base_share[row][0], owner);
    EXPECT_EQ(as_float(f.base_share[row][1]), static_cast<float>(t.stiffness[owner] * t.weight[row]));
  }
}

// Every corner of every base and volume is in the list of its particle, once.
TEST(FloatTables, ListsNameEveryRow) {
  const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2, 18);
  const TopologyTextures t = build_topology(model, {.volume_stiffness = 50.0});
  const FloatTables f = pack_floats(t);
  ASSERT_FALSE(f.volume.empty());
  EXPECT_EQ(f.reaction.size(), 3 * f.base.size());
  EXPECT_EQ(f.volume_entry.size(), 4 * f.volume.size());
  ASSERT_EQ(f.lists.size(), f.particle.size() + 1);
  for (Index i = 0; i < f.particle_count; ++i) {
    const Int4 &first = f.lists[i], &last = f.lists[i + 1];
    for (Index r = first[0]; r < last[0]; ++r) EXPECT_EQ(f.base[f.reaction[r] / 4][f.reaction[r] % 4], i);
    for (Index r = first[1]; r < last[1]; ++r) EXPECT_EQ(f.volume[f.volume_entry[r] / 4][f.volume_entry[r] % 4], i);
    EXPECT_EQ(first[2], last[2]);
  }
  for (Index v = 0; v < f.volume_count; ++v) {
    const double six_volumes =
        vector_of(f.volume_e1[v]).cross(vector_of(f.volume_e2[v])).dot(vector_of(f.volume_e3[v]));
    EXPECT_NEAR(six_volumes * f.volume_e1[v][3], 1.0, 1e-6);
  }
}

TEST(FloatTables, SpringsAreSeenFromBothEnds) {
  TopologyOptions options;
  options.law = Law::springs;
  const Model model = cylinder_275();
  const TopologyTextures t = build_topology(model, options);
  const FloatTables f = pack_floats(t);
  EXPECT_TRUE(f.base.empty() && f.neighbour.empty() && f.reaction.empty());
  EXPECT_FALSE(f.has_attractors());
  ASSERT_EQ(f.spring.size(), 2 * t.springs.size());
  for (Index i = 0; i < f.particle_count; ++i) {
    for (Index r = f.lists[i][3]; r < f.lists[i + 1][3]; ++r) {
      const Vec3 edge = t.rest[f.spring_other[r]] - t.rest[i];
      EXPECT_EQ(vector_of(f.spring[r]), edge.cast<float>().cast<double>());
    }
  }
}

TEST(FloatTables, OnlyWhatTheReactionNeedsIsPacked) {
  const Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  const FloatTables conservative = pack_floats(built(model, Reaction::conservative));
  EXPECT_TRUE(conservative.neighbour.empty() && conservative.alpha.empty() && conservative.share.empty());
  EXPECT_FALSE(conservative.has_attractors());
  const FloatTables averaged = pack_floats(built(model, Reaction::averaged));
  EXPECT_TRUE(averaged.has_attractors() && averaged.share.empty());
  EXPECT_EQ(averaged.reaction.size(), 3 * averaged.base.size());
  for (const Reaction reaction : {Reaction::full, Reaction::shared, Reaction::barycentric}) {
    const TopologyTextures t = built(model, reaction);
    const FloatTables f = pack_floats(t);
    EXPECT_TRUE(f.has_attractors() && f.reaction.empty());
    ASSERT_EQ(f.share.size(), f.neighbour.size());
    double given = 0.0;  // by all: each owner's own force once, Nc times where it is full
    for (const Int2& share : f.share) given += as_float(share[1]);
    EXPECT_NEAR(given, reaction == Reaction::full ? t.neighbour_count : t.particle_count, 1e-4 * t.neighbour_count);
  }
}

TEST(FloatTables, EnumeratedHeightsAreThoseOfTheBases) {
  for (const Body& body : bodies()) {
    if (body.model.dimension == 2) continue;
    const TopologyTextures t = built(body.model, Reaction::shared, BaseSelection::all);
    const FloatTables f = pack_floats(t, FloatLayout::enumerated);
    EXPECT_TRUE(f.base.empty() && f.alpha.empty());
    ASSERT_EQ(f.edge_alpha.size(), f.neighbour.size());
    double heights = 0.0, expected = 0.0;
    for (const Float4& texel : f.height) {
      for (const float height : texel) heights += std::abs(height);
    }
    for (Index row = 0; row < t.base_count; ++row) expected += std::abs(t.weight[row] * t.bases[row].beta);
    EXPECT_NEAR(heights, expected, 1e-6 * expected) << body.name;
  }
}

TEST(FloatTables, EnumerationIsRefusedWhereTheTableIsNeeded) {
  const Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2), strip = make_strip(0.04, 0.02, 4, 2);
  const auto message = [](const TopologyTextures& t) {
    return message_of([&] { pack_floats(t, FloatLayout::enumerated); });
  };
  const std::string text = "bases can be enumerated from the neighbours only in 3-D";
  EXPECT_TRUE(says(message(built(block, Reaction::shared)), text));
  EXPECT_TRUE(says(message(built(block, Reaction::conservative, BaseSelection::all)), text));
  EXPECT_TRUE(says(message(built(block, Reaction::averaged, BaseSelection::all)), text));
  EXPECT_TRUE(says(message(built(strip, Reaction::shared, BaseSelection::all)), text));
}

TEST(FloatTables, WhatNoFloatHoldsIsRefused) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  model.mass[0] = 1e-50;
  EXPECT_TRUE(refuses([&] { pack_floats(built(model, Reaction::conservative)); }, "beyond the range of single"));
  const Model tiny = make_block({2e-10, 2e-10, 2e-10}, 2, 2, 2);
  EXPECT_TRUE(refuses([&] { pack_floats(built(tiny, Reaction::conservative)); }, "Expected a model in metres"));
}

TEST(FloatTables, RestThresholdsFollowTheDisplacement) {
  const RestThresholds asked{1e-6, 1e-2};  // omega 1e4
  EXPECT_EQ(rest_thresholds(asked, 0.0).speed, asked.speed);
  const RestThresholds far = rest_thresholds(asked, 1.0);
  EXPECT_DOUBLE_EQ(far.speed, rest_noise * 1e4);
  EXPECT_DOUBLE_EQ(far.acceleration, rest_noise * 1e8);
  EXPECT_EQ(rest_thresholds({0.0, 0.0}, 1.0).speed, 0.0);
}

}  // namespace
}  // namespace phymul::test
