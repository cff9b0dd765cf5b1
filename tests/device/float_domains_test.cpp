// SPDX-License-Identifier: MIT
//
// The tables of Law::particle_averaged in single precision, plain and in slices: the rows of TopologyTextures under
// other numbers.
#include "device/float_domains.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "device/slice_tables.h"
#include "support/bodies.h"

namespace phymul::test {
namespace {

TopologyTextures averaged(const Model& model) {
  TopologyOptions options;
  options.law = Law::particle_averaged;
  return build_topology(model, options);
}

Model block() {
  Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  set_material(model, soft_tissue());
  return model;
}

Model block_of_two_materials() {
  Model model = block();
  model.add_group("one", model.cells[0].particles);
  set_material(model, {50e3, 0.2, 1500.0}, "one");
  return model;
}

/// Whose tables are compared: domains by number, particles and rows.
struct Numbered {
  const FloatDomains& domains;
  Index stride;                 // from row to row of a domain
  std::vector<Index> particle;  // of TopologyTextures, of each row of `owner` or, where there is none, of each domain

  Index owner(Index d) const { return particle[domains.owner.empty() ? d : domains.owner[d]]; }
};

/// The domains of each particle, and their rows, are those of the topology, in its order.
void expect_the_rows_of(const TopologyTextures& t, const Numbered& n) {
  const FloatDomains& f = n.domains;
  std::vector<Index> number_of(t.domains.size(), none);
  for (Index number = 0; number < f.count(); ++number) {
    if (number >= static_cast<Index>(n.particle.size()) || n.particle[number] == none) continue;
    const Index i = n.particle[number];
    Index d = t.first_domain[i];
    for (Index at = number; at != none && d < t.first_domain[i + 1]; at = f.range[at][3]) number_of[d++] = at;
    EXPECT_EQ(d, t.first_domain[i + 1]) << "particle " << i;
  }
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    const Index at = number_of[d];
    ASSERT_NE(at, none);
    EXPECT_EQ(n.owner(at), t.domains[d].particle);
    EXPECT_EQ(f.law[at][0], static_cast<float>(t.domains[d].inverse_volume));
    EXPECT_EQ(f.law[at][1], static_cast<float>(t.domains[d].spread_stiffness));
    Index row = f.range[at][0];
    const auto expect_row = [&](Index e, const Vec3& area, double stiffness) {
      EXPECT_EQ(f.neighbour[row], number_of[e]);
      const Float4 expected{static_cast<float>(area.x()), static_cast<float>(area.y()), static_cast<float>(area.z()),
                            static_cast<float>(stiffness)};
      EXPECT_EQ(f.link[row], expected);
      row += n.stride;
    };
    for (Index r = t.first_link[d]; r < t.first_link[d + 1]; ++r) {
      expect_row(t.links[r].domain, t.links[r].area, t.links[r].stiffness);
    }
    EXPECT_EQ(row, f.range[at][1]);
    for (Index r = t.first_surface_link[d]; r < t.first_surface_link[d + 1]; ++r) {
      expect_row(t.surface_links[r].domain, t.surface_links[r].area, 0.0);
    }
    EXPECT_EQ(row, f.range[at][2]);
  }
}

std::vector<Index> counted(Index count) {
  std::vector<Index> all;
  for (Index i = 0; i < count; ++i) all.push_back(i);
  return all;
}

TEST(FloatDomains, RowsAreThoseOfTheTopology) {
  for (const Model& model : {block(), block_of_two_materials()}) {
    const TopologyTextures topology = averaged(model);
    const FloatTables tables = pack_floats(topology);
    expect_the_rows_of(topology, {tables.domains, 1, counted(model.particle_count())});
    const SliceTables slices = pack_slices(tables, topology);
    expect_the_rows_of(topology, {slices.rows.domains, slices.slice, slices.order});
    EXPECT_EQ(slices.rows.domains.count() % slices.slice, 0);
  }
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

}  // namespace
}  // namespace phymul::test
