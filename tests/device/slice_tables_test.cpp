// SPDX-License-Identifier: MIT
//
// Packing of the constants in slices of lanes: the same rows in the same order, and little padding.
#include "device/slice_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

struct Packed {
  std::string name;
  TopologyTextures topology;
  FloatTables plain;
};

TopologyOptions full_set(Reaction reaction) {
  TopologyOptions options;
  options.reaction = reaction;
  options.bases = BaseSelection::all;
  return options;
}

void add(std::vector<Packed>& all, const std::string& name, const Model& model, const TopologyOptions& options,
         FloatLayout layout = FloatLayout::table) {
  Packed packed{name, build_topology(model, options), {}};
  packed.plain = pack_floats(packed.topology, layout);
  all.push_back(std::move(packed));
}

std::vector<Packed> every_variant() {
  std::vector<Packed> all;
  for (const Body& body : bodies()) {
    for (const Variant& variant : clustered_variants()) {
      add(all, body.name + ", " + variant.name, prepared(variant, body), variant.options);
    }
    for (const Reaction reaction : {Reaction::full, Reaction::shared, Reaction::barycentric}) {
      const std::string name = body.name + ", shares";
      add(all, name, body.model, full_set(reaction));
      if (body.model.dimension == 3) {
        add(all, name + ", enumerated", body.model, full_set(reaction), FloatLayout::enumerated);
      }
    }
  }
  return all;
}

/// The rows of a place's range, as a shader walks them.
std::vector<Index> walked(const SliceTables& s, const std::vector<Int2>& ranges, Index place) {
  std::vector<Index> rows;
  if (ranges.empty()) return rows;
  for (Index row = ranges[place][0]; row < ranges[place][1]; row += s.slice) rows.push_back(row);
  return rows;
}

template <class Row>
bool same_bits(const Row& a, const Row& b) {
  return std::memcmp(&a, &b, sizeof(Row)) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): -0 is not 0 here
}

/// Goes through the lists of all particles side by side, in both tables.
class Walk {
 public:
  Walk(const SliceTables& sliced, const FloatTables& plain) : s(sliced), f(plain), base_row(plain.base.size(), none) {}

  /// compare(row there, row here) for each row of each particle's list; counts rows.
  template <class Bounds, class Compare>
  void lists(const std::vector<Int2>& ranges, std::size_t rows, const Bounds& bounds, const Compare& compare) const {
    ASSERT_EQ(ranges.empty(), rows == 0);
    if (rows == 0) return;
    ASSERT_EQ(ranges.size(), s.order.size());
    std::size_t seen = 0;
    for (Index place = 0; place < s.place_count(); ++place) {
      const std::vector<Index> here = walked(s, ranges, place);
      if (s.order[place] == none) {
        ASSERT_TRUE(here.empty());
        continue;
      }
      const auto [first, end] = bounds(s.order[place]);
      ASSERT_EQ(static_cast<Index>(here.size()), end - first);
      for (std::size_t e = 0; e < here.size(); ++e) {
        ASSERT_EQ(here[e] % s.slice, place % s.slice) << "lane";
        ASSERT_TRUE(compare(first + static_cast<Index>(e), here[e])) << "place " << place << ", entry " << e;
      }
      seen += here.size();
    }
    ASSERT_EQ(seen, rows);
  }

  Index model_row(Index place) const { return place == none ? none : s.order[place]; }
  Int4 renamed(Int4 v, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) v[i] = model_row(v[i]);
    return v;
  }

  void neighbours() {
    const auto bounds = [&](Index i) { return std::pair(f.index[i][1], f.index[i][1] + f.index[i][0]); };
    lists(s.neighbours, f.neighbour.size(), bounds, [&](Index a, Index b) {
      return f.neighbour[a] == model_row(s.rows.neighbour[b]) &&
             (f.alpha.empty() || same_bits(f.alpha[a], s.rows.alpha[b])) &&
             (f.edge_alpha.empty() || same_bits(f.edge_alpha[a], s.rows.edge_alpha[b]));
    });
    const auto heights = [&](Index i) {
      const auto row = static_cast<std::size_t>(i) + 1;
      return std::pair(f.first_height[i],
                       row < f.first_height.size() ? f.first_height[row] : static_cast<Index>(f.height.size()));
    };
    lists(s.heights, f.height.size(), heights,
          [&](Index a, Index b) { return same_bits(f.height[a], s.rows.height[b]); });
  }

  void bases() {
    const auto bounds = [&](Index i) { return std::pair(f.index[i][3], f.index[i][3] + f.index[i][2]); };
    lists(s.bases, f.base.size(), bounds, [&](Index a, Index b) {
      base_row[a] = b;
      const Int2 share{model_row(s.rows.base_share[b][0]), s.rows.base_share[b][1]};
      return f.base[a] == renamed(s.rows.base[b], 3) && same_bits(f.base_e1[a], s.rows.base_e1[b]) &&
             same_bits(f.base_e2[a], s.rows.base_e2[b]) && f.base_share[a] == share;
    });
  }

  auto list(std::size_t kind) const {
    return [this, kind](Index i) { return std::pair(f.lists[i][kind], f.lists[i + 1][kind]); };
  }

  void reactions() {
    lists(s.reactions, f.share.size() + f.reaction.size(), list(0), [&](Index a, Index b) {
      if (f.share.empty()) return s.rows.reaction[b] == base_row[f.reaction[a] / 4] * 4 + f.reaction[a] % 4;
      return f.share[a] == Int2{model_row(s.rows.share[b][0]), s.rows.share[b][1]};
    });
    lists(s.springs, f.spring.size(), list(2), [&](Index a, Index b) {
      return f.spring_other[a] == model_row(s.rows.spring_other[b]) && same_bits(f.spring[a], s.rows.spring[b]);
    });
  }

  void volumes() {
    ASSERT_EQ(s.rows.volume.size(), f.volume.size());
    lists(s.volumes, f.volume_entry.size(), list(1), [&](Index a, Index b) {
      const Index there = f.volume_entry[a], here = s.rows.volume_entry[b];
      const Index v = there / 4, w = here / 4;
      return there % 4 == here % 4 && f.volume[v] == renamed(s.rows.volume[w], 4) &&
             same_bits(f.volume_e1[v], s.rows.volume_e1[w]) && same_bits(f.volume_e2[v], s.rows.volume_e2[w]) &&
             same_bits(f.volume_e3[v], s.rows.volume_e3[w]);
    });
  }

  const SliceTables& s;
  const FloatTables& f;
  std::vector<Index> base_row;  // new row of each old base
};

TEST(SliceTables, WalkingThemGivesTheRowsInTheirOrder) {
  for (const Packed& packed : every_variant()) {
    for (const int slice : {32, 5, 1}) {
      SCOPED_TRACE(packed.name + ", slices of " + std::to_string(slice));
      const SliceTables s = pack_slices(packed.plain, packed.topology, slice);
      Walk walk(s, packed.plain);
      walk.neighbours();
      walk.bases();
      walk.reactions();
      walk.volumes();
      EXPECT_EQ(s.rows.particle_count, packed.plain.particle_count);
      EXPECT_EQ(s.rows.base_count, static_cast<Index>(s.rows.base.size()));
      EXPECT_TRUE(s.rows.index.empty() && s.rows.lists.empty() && s.rows.first_height.empty());
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(SliceTables, EveryParticleHasOnePlaceAndPaddingIsAtTheEnd) {
  for (const Packed& packed : every_variant()) {
    const SliceTables s = pack_slices(packed.plain, packed.topology);
    const Index n = packed.plain.particle_count;
    ASSERT_EQ(s.place_count(), (n + 31) / 32 * 32);
    ASSERT_EQ(s.place_of.size(), static_cast<std::size_t>(n));
    ASSERT_EQ(s.rows.particle.size(), s.order.size());
    for (Index place = n; place < s.place_count(); ++place) {
      EXPECT_EQ(s.order[place], none);
      EXPECT_EQ(s.rows.particle[place], Float4{});
    }
    for (Index i = 0; i < n; ++i) {
      ASSERT_TRUE(s.place_of[i] >= 0 && s.place_of[i] < n);
      ASSERT_EQ(s.order[s.place_of[i]], i);
      EXPECT_TRUE(same_bits(s.rows.particle[s.place_of[i]], packed.plain.particle[i]));
    }
  }
}

/// Rows that no range holds.
std::vector<Index> padding(const SliceTables& s, const std::vector<Int2>& ranges, std::size_t rows) {
  std::vector<bool> held(rows, false);
  for (Index place = 0; place < s.place_count(); ++place) {
    for (const Index row : walked(s, ranges, place)) held[row] = true;
  }
  std::vector<Index> result;
  for (std::size_t row = 0; row < rows; ++row) {
    if (!held[row]) result.push_back(static_cast<Index>(row));
  }
  return result;
}

TEST(SliceTables, PaddingNamesNobodyAndWeighsNothing) {
  std::size_t padded = 0;
  for (const Packed& packed : every_variant()) {
    SCOPED_TRACE(packed.name);
    const SliceTables s = pack_slices(packed.plain, packed.topology);
    const FloatTables& t = s.rows;
    const auto each = [&](const std::vector<Int2>& ranges, std::size_t rows, const auto& check) {
      if (rows == 0) return;  // reactions are of one of two tables
      for (const Index row : padding(s, ranges, rows)) {
        ASSERT_TRUE(check(row)) << "row " << row;
        ++padded;
      }
    };
    each(s.neighbours, t.neighbour.size(), [&](Index r) {
      return t.neighbour[r] == none && (t.alpha.empty() || t.alpha[r] == 0.0f) &&
             (t.edge_alpha.empty() || t.edge_alpha[r] == Float4{});
    });
    each(s.heights, t.height.size(), [&](Index r) { return t.height[r] == Float4{}; });
    each(s.bases, t.base.size(), [&](Index r) {
      return t.base[r] == Int4{none, none, none, 0} && t.base_e1[r] == Float4{} && t.base_e2[r] == Float4{} &&
             t.base_share[r] == Int2{none, 0};
    });
    each(s.reactions, t.share.size(), [&](Index r) { return t.share[r] == Int2{none, 0}; });
    each(s.reactions, t.reaction.size(), [&](Index r) { return t.reaction[r] == none; });
    each(s.volumes, t.volume_entry.size(), [&](Index r) { return t.volume_entry[r] == none; });
    each(s.springs, t.spring.size(), [&](Index r) { return t.spring_other[r] == none && t.spring[r] == Float4{}; });
  }
  EXPECT_GT(padded, 1000u);
}

TEST(SliceTables, PackingTwiceGivesTheSame) {
  Model model = jittered_block();
  set_material(model, soft_tissue());
  const TopologyTextures topology = build_topology(model);
  const SliceTables a = pack_slices(pack_floats(topology), topology), b = pack_slices(pack_floats(topology), topology);
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.bases, b.bases);
  EXPECT_EQ(a.rows.base, b.rows.base);
  EXPECT_EQ(a.rows.reaction, b.rows.reaction);
  EXPECT_EQ(a.rows.volume, b.rows.volume);
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
  TopologyOptions springs;
  springs.law = Law::springs;
  springs.volume_stiffness = 50.0;
  for (const Body& body : all) {
    ASSERT_GT(body.model.particle_count(), 4096);
    std::vector<Packed> packed;
    add(packed, "enumerated", body.model, full_set(Reaction::shared), FloatLayout::enumerated);
    add(packed, "springs, volumes", body.model, springs);
    if (body.name == "tetrahedra") add(packed, "conservative", body.model, {});  // rows uneven as they can be
    Model material = body.model;
    set_material(material, soft_tissue());
    add(packed, "material", material, {});
    for (Packed& p : packed) {
      const double share = padding_share(pack_slices(std::move(p.plain), p.topology));
      const std::string name = body.name + ", " + p.name;
      std::printf("%-28s %.3f rows for one that is used\n", name.c_str(), share);
      EXPECT_LT(share, body.name == "lattice" ? 1.02 : 1.15) << name;
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
  const std::string message = message_of([&] { pack_slices(huge, topology); });
  EXPECT_TRUE(says(message, "the sliced table of bases has"));
  EXPECT_TRUE(says(message, "slices of 32 lanes; 536870903 fit"));
}

}  // namespace
}  // namespace phymul::test
