// SPDX-License-Identifier: MIT
//
// Materials with fibres: StrainEnergy::fibres.
#include <gtest/gtest.h>

#include "support/bodies.h"
#include "support/mechanics.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

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

}  // namespace
}  // namespace phymul::test
