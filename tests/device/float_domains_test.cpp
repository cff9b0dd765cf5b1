// SPDX-License-Identifier: MIT
//
// The tables of Law::particle_averaged in single precision: which domains there are.
#include "device/float_domains.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "device/float_tables.h"
#include "support/bodies.h"

namespace phymul::test {
namespace {

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

}  // namespace
}  // namespace phymul::test
