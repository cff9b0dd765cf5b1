// SPDX-License-Identifier: MIT
//
// Packing of the constants for float backends: what is packed, and what is refused. The numbers are those of Mirror and
// MirrorKernels. Packing of the constants in slices of lanes: little padding, and neighbours near each other. That they
// are the rows of the body GlEquivalence and GlAveraged show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "device/float_domains.h"
#include "device/float_range.h"
#include "device/float_scene.h"
#include "device/float_tables.h"
#include "device/slice_tables.h"
#include "mirror/mirror.h"
#include "mirror/mirror_scene.h"
#include "model/closed_surface.h"
#include "support/bodies.h"
#include "support/cut_bodies.h"
#include "support/mechanics.h"
#include "support/message_of.h"
#include "support/run_scenes.h"

namespace phymul::test {
namespace {

float as_float(std::int32_t bits) {
  return std::bit_cast<float>(bits);
}

TopologyTextures built(const Model& model, Reaction reaction, BaseSelection bases = BaseSelection::thresholded) {
  return build_topology(model, {.reaction = reaction, .bases = bases});
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

TEST(FloatTables, ASurfacesPlacesAreSumsOfTwoFloats) {
  const Model block = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  const Model both = with_material(merged({{"near", &block}, {"far", &block}}));
  Model apart = both;
  for (const Index i : apart.group("far")) apart.rest[i] += Vec3(0.3111, 0.1, 0.0207);
  Scene scene(apart);
  scene.contacts({});
  const FloatContacts contacts(scene);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& X : apart.rest) middle += X / static_cast<double>(apart.rest.size());
  ASSERT_EQ(contacts.rest.size(), 2 * contacts.particle.size());
  for (std::size_t k = 0; k < contacts.particle.size(); ++k) {
    const Vec3 X = apart.rest[contacts.particle[k][0]] - middle;
    EXPECT_LE((widened(contacts.rest[2 * k]) + widened(contacts.rest[2 * k + 1]) - X).norm(), 0x1p-47 * X.norm());
  }
}

TEST(FloatTables, RestThresholdsFollowTheDisplacement) {
  const RestThresholds asked{1e-6, 1e-2};  // omega 1e4
  EXPECT_EQ(rest_thresholds(asked, 0.0).speed, asked.speed);
  const RestThresholds far = rest_thresholds(asked, 1.0);
  EXPECT_DOUBLE_EQ(far.speed, rest_noise * 1e4);
  EXPECT_DOUBLE_EQ(far.acceleration, rest_noise * 1e8);
  EXPECT_EQ(rest_thresholds({0.0, 0.0}, 1.0).speed, 0.0);
}

// The tables of Law::particle_averaged in single precision: which domains there are.

TopologyTextures averaged(const Model& model) {
  return build_topology(model, {.law = Law::particle_averaged});
}

Model block() {
  return with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
}

Model block_of_two_materials() {
  Model model = block();
  model.add_group("one", model.cells[0].particles);
  set_material(model, {50e3, 0.2, 1500.0}, "one");
  return model;
}

TEST(FloatDomains, OnlySeveralMaterialsNeedOwners) {
  const FloatDomains one = pack_domains(averaged(block())), two = pack_domains(averaged(block_of_two_materials()));
  EXPECT_TRUE(one.owner.empty());
  EXPECT_EQ(one.count(), block().particle_count());
  EXPECT_EQ(two.count(), block().particle_count() + 7);  // corners of the cell but one that other cells share
  EXPECT_EQ(static_cast<Index>(two.owner.size()), two.count());
  EXPECT_EQ(std::ranges::count_if(two.range, [](const Int4& range) { return range[3] != none; }), 7);
}

TEST(FloatDomains, AParticleOfNoCellHasAnEmptyDomain) {
  Model model = block();
  TopologyTextures topology = averaged(model);
  // As if a particle without cells came before the others.
  ++topology.particle_count;
  topology.rest.insert(topology.rest.begin(), Vec3(1, 1, 1));
  topology.mass.insert(topology.mass.begin(), 1.0);
  topology.index.insert(topology.index.begin(), IndexTexel{});
  topology.first_domain.insert(topology.first_domain.begin(), 0);
  for (DomainTexel& domain : topology.domains) ++domain.particle;
  const FloatDomains domains = pack_domains(topology);
  EXPECT_EQ(domains.count(), topology.particle_count);
  EXPECT_TRUE(domains.owner.empty());
  EXPECT_EQ(domains.range[0], (Int4{0, 0, 0, none}));
  EXPECT_EQ(domains.law[0], Float4{});
  for (const std::int32_t e : domains.neighbour) EXPECT_GE(e, 1);
}

TEST(FloatDomains, OtherLawsHaveNone) {
  const FloatTables tables = pack_floats(build_topology(make_block({0.03, 0.02, 0.02}, 3, 2, 2)));
  EXPECT_EQ(tables.domains.count(), 0);
  EXPECT_TRUE(tables.domains.link.empty());
}

/// Shaders read every vertex of every row, and add to those that there are.
TEST(FloatWalls, RowsAreThoseOfTrianglesThatAreThere) {
  TopologyTextures topology = build_topology(sheet());
  const auto before = static_cast<Index>(topology.walls.size());
  topology.walls[3].shear = 0.0;  // a removed one's
  const FloatTables tables = pack_floats(topology);
  const FloatWalls& walls = tables.walls;
  ASSERT_EQ(walls.count(), before - 1);
  ASSERT_EQ(walls.law.size(), static_cast<std::size_t>(FloatWalls::law_texels * walls.count()));
  std::size_t present = 0, missing = 0;
  for (Index row = 0; row < walls.count(); ++row) {
    const WallTexel& wall = topology.walls[row < 3 ? row : row + 1];
    for (Index k = 0; k < 6; ++k) {
      const Index v = walls.vertex[2 * row + k / 4][static_cast<std::size_t>(k % 4)];
      const Index own = wall.vertex[static_cast<std::size_t>(k)];
      EXPECT_EQ(v, own == none ? wall.vertex[0] : own);
      ++(own == none ? missing : present);
      if (own == none) continue;
      const std::int32_t entry = 8 * row + k;
      EXPECT_EQ(std::count(walls.entries.begin(v), walls.entries.end(v), entry), 1);
    }
  }
  EXPECT_GT(missing, 0u);
  EXPECT_EQ(walls.entries.entry.size(), present);
  EXPECT_EQ(tables.lists.back()[3], static_cast<Index>(present));
}

/// Also where a particle of a capsule gathers from domains.
TEST(FloatWalls, TurnsOfTheirGatheringCount) {
  for (const Model& model : {sheet(), slab_in_capsule()}) {
    const FloatTables tables = pack_floats(build_topology(model));
    Index most = 0;
    for (Index i = 0; i < tables.particle_count; ++i) {
      Index turns = tables.walls.entries.size(i);
      if (tables.domains.count() > 0) turns += tables.domains.range[i][2] - tables.domains.range[i][0] + 1;
      most = std::max(most, turns);
    }
    EXPECT_EQ(tables.turns.gathered, most);
  }
}

TEST(FloatWalls, ConstantsBeyondSinglePrecisionAreRefused) {
  TopologyTextures topology = build_topology(sheet(2));
  topology.walls[1].bending[4] = 1e40;
  EXPECT_TRUE(refuses([&] { pack_floats(topology); }, "is beyond the range of single precision"));
}

TEST(FloatWalls, OtherBodiesHaveNone) {
  const FloatTables tables = pack_floats(averaged(block()));
  EXPECT_EQ(tables.walls.count(), 0);
  EXPECT_TRUE(tables.walls.entries.entry.empty());
}

// Kept volumes in single precision, as far as no device is needed: tables, the root, and the mirror against the
// reference.

/// Far from where a branch ends both find the same root or none.
TEST(FloatVolumes, RootsAreThoseInDoublePrecision) {
  std::mt19937 bits(12);
  int roots = 0, none = 0;
  for (int k = 0; k < 20000; ++k) {
    const float c1 = static_cast<float>(std::pow(10.0, 3.0 * uniform(bits))), c2 = static_cast<float>(uniform(bits)),
                c3 = static_cast<float>(uniform(bits));
    const float wanted = static_cast<float>(2.0 * uniform(bits));
    const auto exact = root_of_cubic({c1, c2, c3}, wanted);
    const auto near = root_of_cubic({c1, c2, c3}, 1.001 * wanted), nearer = root_of_cubic({c1, c2, c3}, 0.999 * wanted);
    const cpu::VolumeRoot root = cpu::root_of_cubic(c1, c2, c3, wanted);
    if (near.has_value() != nearer.has_value()) continue;
    ASSERT_EQ(root.found, exact.has_value()) << c1 << ' ' << c2 << ' ' << c3 << ' ' << wanted;
    if (!root.found) {
      ++none;
      continue;
    }
    ++roots;
    const double s = root.s, c_s = std::abs(c1 * s) + std::abs(c2 * s * s) + std::abs(c3 * s * s * s);
    EXPECT_NEAR(((c3 * s + c2) * s + c1) * s, wanted, 16.0 * 0x1p-24 * (c_s + std::abs(wanted)));
    EXPECT_NEAR(s, *exact, std::abs(*near - *nearer)) << c1 << ' ' << c2 << ' ' << c3 << ' ' << wanted;
  }
  EXPECT_GT(roots, 10000);
  EXPECT_GT(none, 100);
  EXPECT_FALSE(cpu::root_of_cubic(0.0f, 1.0f, 1.0f, 0.1f).found);
  EXPECT_FALSE(cpu::root_of_cubic(-1.0f, 0.0f, 1.0f, 0.1f).found);
  EXPECT_FALSE(cpu::root_of_cubic(1.0f, 0.0f, 0.0f, NAN).found);
  EXPECT_FALSE(cpu::root_of_cubic(INFINITY, 0.0f, 0.0f, 1.0f).found);
  EXPECT_EQ(cpu::root_of_cubic(1.0f, 1.0f, 1.0f, 0.0f).s, 0.0f);
}

/// Held, squeezed and let go again, the rest of it at rest: see KeptVolume.LeavesHeldParticlesAndComesToRest.
TEST(FloatVolumes, TheMirrorComesToRestWithItsVolume) {
  Model model = make_block({0.03, 0.02, 0.02}, 6, 4, 4);
  for (double& k : model.stiffness) k = 5.0;
  for (double& m : model.mass) m = 1e-4;
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81}).constrain_volume();
  const SolverOptions options{.damping = {.rate = 30.0}, .rest_tolerance = 1e-5};
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, {}));
  const auto mirror = cpu::make_mirror_solver(tables, scene, options);
  const auto reference = make_solver("reference", tables, scene, options);
  const double dt = 0.4 * reference->stable_step();
  const RestResult a = mirror->run_to_rest(100000, dt), b = reference->run_to_rest(100000, dt);
  EXPECT_TRUE(a.converged() && b.converged()) << a.message();
  EXPECT_NEAR(a.report.steps, b.report.steps, 0.02 * b.report.steps);
  const State x = mirror->read(), y = reference->read();
  const double moved = largest_distance(y.position, model.rest), off = largest_distance(x.position, y.position);
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(off, 1e-4 * moved);
  const VolumeConstraint& kept = scene.volume_constraints()[0];
  EXPECT_NEAR(enclosed_volume(kept.triangles, x.position) / kept.volume, 1.0, 1e-6);
}

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
