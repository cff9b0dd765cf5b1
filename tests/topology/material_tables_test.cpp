// SPDX-License-Identifier: MIT
//
// From a material to tables, and what may stand in the way.
#include <gtest/gtest.h>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

TEST(MaterialTables, StiffnessIsWhatTheMaterialSaysNotWhatTheModelHeld) {
  Model block = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  const VecList stretched = random_positions(block, 0.1, 1);
  const double before = elastic_energy(build_topology(block), stretched);
  std::fill(block.stiffness.begin(), block.stiffness.end(), 1e9);
  EXPECT_EQ(elastic_energy(build_topology(block), stretched), before);
  set_material(block, {20e3, 0.3, 1000});
  EXPECT_NEAR(elastic_energy(build_topology(block), stretched), 2 * before, 1e-9 * before);
}

TEST(MaterialTables, TheLawFollowsFromTheModel) {
  Model block = make_block({0.02, 0.02, 0.02}, 2, 2, 2, 26);
  EXPECT_EQ(build_topology(block).options.law, Law::shape_memory);
  set_material(block, soft_tissue());
  EXPECT_EQ(build_topology(block).options.law, Law::particle_averaged);
}

TEST(MaterialTables, WhatCannotCarryAMaterialSaysSo) {
  const Model block = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  const auto refuse = [](const Model& model, auto&& set) {
    TopologyOptions options;
    set(options);
    return message_of([&] { build_topology(model, options); });
  };
  for (const Law law : {Law::springs, Law::shape_memory}) {
    EXPECT_TRUE(says(refuse(block, [&](TopologyOptions& o) { o.law = law; }), "take their stiffness in N/m"));
  }
  EXPECT_TRUE(
      says(refuse(block, [](TopologyOptions& o) { o.reaction = Reaction::shared; }), "needs Reaction::conservative"));
  EXPECT_TRUE(says(refuse(block, [](TopologyOptions& o) { o.volume_stiffness = 1; }),
                   "volume_stiffness is for models without"));
  Model holed = block;
  holed.cells[3].material = -1;
  change_extras(holed, [](FileExtras& extras) { extras.cell_index = {-1, -1, -1, 12}; });
  EXPECT_TRUE(says(refuse(holed, [](TopologyOptions&) {}), "cell 3 (HEXAHEDRON, file index 12) has no material"));
  Model two = block;
  two.materials.push_back(soft_tissue(0.1));
  two.cells[0].material = 1;
  EXPECT_EQ(refuse(two, [](TopologyOptions&) {}), "(no error)");
}

}  // namespace
}  // namespace phymul::test
