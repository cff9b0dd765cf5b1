// SPDX-License-Identifier: MIT
//
// From a material to tables, and what may stand in the way.
#include <gtest/gtest.h>
#include <phymul/bodies.h>

#include "model/file_extras.h"
#include "support/bodies.h"
#include "support/mechanics.h"
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

// Materials with fibres: StrainEnergy::fibres.

/// Along its fibres a body has the Young's modulus asked for; across them they hinder the narrowing alone.
TEST(Fibres, MakeABodyStifferAlongThemAlone) {
  for (Model model :
       {make_block({0.04, 0.02, 0.02}, 4, 2, 2), make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.2, 3)}) {
    Material tissue = soft_tissue(0.3);
    tissue.fibre_ratio = 5.0;
    set_material(model, tissue);
    for (const Vec3& along : {Vec3(2, 0, 0), Vec3(0, 0, 1)}) {
      for (std::size_t c = 0; c < model.cells.size(); ++c) model.cells[c].fibre = c % 2 == 0 ? along : Vec3(-along);
      const TopologyTextures tables = build_topology(model);
      EXPECT_EQ(tables.options.strain_energy, StrainEnergy::fibres);
      const Moduli found = stretch_block(model, tables, 1e-4);
      const double across = tissue.young / (1.0 - 0.3 * 0.3 * (1.0 - 1.0 / 5.0));
      const double wanted = along.x() > 0.0 ? 5.0 * tissue.young : across;
      EXPECT_NEAR(found.young, wanted, 2e-3 * wanted);
    }
  }
}

TEST(Fibres, WithoutADirectionAreRefused) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Material tissue = soft_tissue(0.3);
  tissue.fibre_ratio = 2.0;
  set_material(model, tissue);
  const auto refused = [&](const TopologyOptions& options) {
    return message_of([&] { build_topology(model, options); });
  };
  EXPECT_TRUE(says(refused({}), "cell 0 (HEXAHEDRON) has a material with fibres but no direction"));
  tissue.fibre_ratio = 0.5;
  EXPECT_TRUE(refuses([&] { set_material(model, tissue); }, "fibre_ratio of 1 (no fibres) or more, got 0.5"));
  model.materials[0].fibre_ratio = 0.5;
  EXPECT_TRUE(says(refused({}), "fibre_ratio of 1 (no fibres) or more, got 0.5"));
}

TEST(Fibres, MayHaveAnyLength) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Material tissue = soft_tissue(0.3);
  tissue.fibre_ratio = 2.0;
  set_material(model, tissue);
  for (const double length : {1.0, 1e-200, 1e200}) {
    for (Cell& cell : model.cells) cell.fibre = Vec3(0, length, 0);
    EXPECT_EQ(build_topology(model).energies.front()[4], 1.0) << length;
  }
}

/// A row of Model::materials that no cell has changes no law.
TEST(MaterialTables, OfMaterialsWithoutCellsTakeNothing) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  set_material(model, soft_tissue(0.3));
  Material fibrous = soft_tissue(0.3), stiffens = fibrous, viscous = fibrous;
  fibrous.fibre_ratio = 2.0;
  stiffens.stiffening = {.exponential = 0.5, .exponent = 1.0};
  viscous.retardation_time = 0.01;
  model.materials.insert(model.materials.end(), {fibrous, stiffens, viscous});
  const TopologyTextures tables = build_topology(model);
  EXPECT_EQ(tables.options.strain_energy, StrainEnergy::neo_hookean);
  EXPECT_TRUE(tables.dissipation.empty());
}

const Vec3 slender(0.2, 0.05, 0.05);

std::vector<std::string> notes(Model model) {
  set_material(model, soft_tissue(0.3));
  return build_topology(model).notes;
}

/// Slivers among good cells are no stretch.
TEST(StretchedCells, GoodMeshesAreNotNamed) {
  for (const Model& model :
       {make_block(slender, 16, 4, 4), make_block({0.2, 0.06, 0.05}, 4, 3, 3), make_cylinder(0.02, 0.1, 2, 8, 10),
        make_tetrahedral_block(slender, 16, 4, 4, 0.45, 1, 0.02), make_strip(0.2, 0.1, 8, 8)}) {
    EXPECT_TRUE(notes(model).empty()) << model.name << ": " << notes(model).front();
  }
}

TEST(StretchedCells, TheBodyIsNamedWithItsStretch) {
  const Model cube = make_block({0.05, 0.05, 0.05}, 4, 4, 4), rod = moved(make_block(slender, 4, 4, 4), {0, 0.1, 0});
  const auto found = notes(merge_models(std::vector<NamedBody>{{"cube", &cube}, {"rod", &rod}}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(
      found.front(),
      "body \"rod\": its cells are 4.0 times as long as thick; it bends too little, whatever the stabiliser. Mesh "
      "it with cells that are less than twice as long as thick");
  EXPECT_EQ(notes(cube).size(), 0u);
}

/// Turned, of tetrahedra, of no two alike, and in the plane.
TEST(StretchedCells, EveryKindOfMeshIsNamed) {
  Model turned = make_block(slender, 4, 4, 4);
  for (Vec3& x : turned.rest) x = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * x;
  for (const Model& model : {turned, make_tetrahedral_block(slender, 4, 4, 4, 0.2, 1), make_strip(0.2, 0.05, 4, 4)}) {
    const auto found = notes(model);
    ASSERT_EQ(found.size(), 1u) << model.name;
    EXPECT_TRUE(says(found.front(), ": its cells are 4."));
  }
}

}  // namespace

}  // namespace phymul::test
