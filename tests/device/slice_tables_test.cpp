// SPDX-License-Identifier: MIT
//
// Packing of the constants in slices of lanes: little padding, and neighbours near each other. That they are the rows
// of the body GlEquivalence and GlAveraged show.
#include "device/slice_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "support/bodies.h"
#include "support/cut_walls.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

struct Packed {
  std::string name;
  TopologyTextures topology;
  FloatTables plain;
};

TopologyOptions full_set(Reaction reaction) {
  return {.reaction = reaction, .bases = BaseSelection::all};
}

void add(std::vector<Packed>& all, const std::string& name, const Model& model, const TopologyOptions& options,
         FloatLayout layout = FloatLayout::table) {
  Packed packed{name, build_topology(model, options), {}};
  packed.plain = pack_floats(packed.topology, layout);
  all.push_back(std::move(packed));
}

/// The rows of a place's range, as a shader walks them.
std::vector<Index> walked(const SliceTables& s, const std::vector<Int2>& ranges, Index place) {
  std::vector<Index> rows;
  if (ranges.empty()) return rows;
  for (Index row = ranges[place][0]; row < ranges[place][1]; row += s.slice) rows.push_back(row);
  return rows;
}

struct Amount {
  std::size_t held = 0, rows = 0;
};

/// Rows of all lists, with their padding over without.
double padding_share(const SliceTables& s) {
  Amount sum;
  const auto add_list = [&](const std::vector<Int2>& ranges, std::size_t rows) {
    sum.rows += rows;
    for (const Int2& range : ranges) sum.held += static_cast<std::size_t>((range[1] - range[0]) / s.slice);
  };
  const FloatTables& t = s.rows;
  add_list(s.neighbours, t.neighbour.size());
  add_list(s.heights, t.height.size());
  add_list(s.bases, t.base.size());
  add_list(s.reactions, t.share.size() + t.reaction.size());
  add_list(s.volumes, t.volume_entry.size());
  add_list(s.springs, t.spring.size());
  add_list(s.walls, t.walls.entries.entry.size());
  for (const Int4& range : t.domains.range) {
    sum.held += static_cast<std::size_t>((range[2] - range[0]) / s.slice);
  }
  sum.rows += t.domains.link.size();
  return static_cast<double>(sum.rows) / static_cast<double>(sum.held);
}

TEST(SliceTables, LittleIsPadding) {
  const Vec3 size(0.17, 0.16, 0.16);
  Model lattice = make_block(size, 17, 16, 16, 14), jittered = lattice;
  jitter(jittered, 0.2, 7);
  const std::vector<Body> all = {
      {"lattice", lattice}, {"jittered", jittered}, {"tetrahedra", make_tetrahedral_block(size, 17, 16, 16, 0.2, 5)}};
  for (const Body& body : all) {
    ASSERT_GT(body.model.particle_count(), 4096);
    std::vector<Packed> packed;
    add(packed, "enumerated", body.model, full_set(Reaction::shared), FloatLayout::enumerated);
    add(packed, "springs, volumes", body.model, {.law = Law::springs, .volume_stiffness = 50.0});
    if (body.name == "tetrahedra") add(packed, "conservative", body.model, {});  // rows uneven as they can be
    const Model material = with_material(body.model);
    add(packed, "material", material, {});
    for (Packed& p : packed) {
      const double share = padding_share(pack_slices(std::move(p.plain), p.topology));
      const std::string name = body.name + ", " + p.name;
      std::printf("%-28s %.3f rows for one that is used\n", name.c_str(), share);
      EXPECT_LT(share, body.name == "lattice" ? 1.02 : 1.15) << name;
    }
  }
}

/// Terms stand in the order of their first place, and entries name them there.
TEST(SliceTables, WallsAreFoundWhereTheirVerticesAre) {
  const TopologyTextures topology = build_topology(sheet(32));
  const FloatTables plain = pack_floats(topology);
  const SliceTables s = pack_slices(plain, topology);
  EXPECT_LT(padding_share(s), 1.15);
  Index least_before = 0;
  for (Index row = 0; row < s.rows.walls.count(); ++row) {
    const auto &first = s.rows.walls.vertex[2 * row], &last = s.rows.walls.vertex[2 * row + 1];
    const Index least = std::min({first[0], first[1], first[2], first[3], last[0], last[1]});
    EXPECT_GE(least, least_before);
    least_before = least;
  }
  for (Index place = 0; place < topology.particle_count; ++place) {
    const std::vector<Index> rows = walked(s, s.walls, place);
    const Index i = s.order[place];
    ASSERT_EQ(static_cast<Index>(rows.size()), plain.walls.entries.size(i));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const Index entry = s.rows.walls.entries.entry[rows[k]], before = plain.walls.entries.begin(i)[k];
      EXPECT_EQ(entry % 8, before % 8);
      EXPECT_EQ(s.rows.walls.vertex[2 * (entry / 8) + entry % 8 / 4][static_cast<std::size_t>(entry % 4)], place);
      for (Index t = 0; t < FloatWalls::law_texels; ++t) {
        EXPECT_EQ(s.rows.walls.law[FloatWalls::law_texels * (entry / 8) + t],
                  plain.walls.law[FloatWalls::law_texels * (before / 8) + t]);
      }
    }
  }
}

TEST(SliceTables, NeighboursHavePlacesNearEachOther) {
  const Model model = make_block({0.16, 0.16, 0.16}, 16, 16, 16, 6);
  const TopologyTextures topology = build_topology(model, full_set(Reaction::shared));
  const SliceTables s = pack_slices(pack_floats(topology, FloatLayout::enumerated), topology);
  std::vector<Index> distance;
  for (Index place = 0; place < model.particle_count(); ++place) {
    for (const Index row : walked(s, s.neighbours, place)) distance.push_back(std::abs(s.rows.neighbour[row] - place));
  }
  std::ranges::nth_element(distance, distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2));
  EXPECT_LE(distance[distance.size() / 2], 256);  // a layer of the lattice has 289
}

TEST(SliceTables, WhatDoesNotFitIsRefused) {
  const Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  const TopologyTextures topology = build_topology(model);
  const FloatTables tables = pack_floats(topology);
  for (const int slice : {0, -32, 1025}) {
    EXPECT_TRUE(refuses([&] { pack_slices(tables, topology, slice); }, "1 to 1024 lanes, not"));
  }
  FloatTables huge = tables;
  huge.index[3][2] = std::numeric_limits<std::int32_t>::max() / 64;  // of one lane: its slice is as long
  EXPECT_TRUE(refuses([&] { pack_slices(huge, topology); }, "the sliced table of bases has",
                      "slices of 32 lanes; 536870903 fit"));
}

}  // namespace
}  // namespace phymul::test
