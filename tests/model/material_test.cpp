// SPDX-License-Identifier: MIT
//
// Young's modulus and Poisson's ratio in, Young's modulus and Poisson's ratio out; and beams that bend as beams do.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "support/bodies.h"
#include "support/mechanics.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

TEST(Material, UniformStretchIsExactOnEveryMesh) {
  const std::vector<std::pair<const char*, Model>> meshes = {
      {"lattice", make_block({0.04, 0.02, 0.03}, 4, 2, 3)},
      {"tetrahedra", make_tetrahedral_block({0.05, 0.04, 0.04}, 5, 4, 4, 0.2, 1)},
      {"tetrahedra, another mesh", make_tetrahedral_block({0.04, 0.03, 0.03}, 4, 3, 3, 0.2, 2)}};
  for (const auto& [name, shape] : meshes) {
    for (const double poisson : {0.0, 0.3, 0.45}) {
      Model model = shape;
      const Material tissue = soft_tissue(poisson);
      set_material(model, tissue);
      const Moduli found = stretch_block(model, build_topology(model), 1e-4);
      std::printf("%-26s nu %.2f: E / asked %.5f, nu found %.5f\n", name, poisson, found.young / tissue.young,
                  found.poisson);
      // Of a strain of 1e-4, and of how far the body was let come to rest.
      EXPECT_NEAR(found.young, tissue.young, 1e-3 * tissue.young) << name;
      EXPECT_NEAR(found.poisson, poisson, 1e-3) << name;
    }
  }
}

/// A ball of 4.19 ml in a block: by centres its volume is met, by particles only the cells wholly in it are.
TEST(Material, RegionsReachTheirVolume) {
  const double radius = 0.01, asked = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
  const auto ball = [&](const Vec3& at) { return (at - Vec3(0.031, 0.03, 0.029)).norm() < radius; };
  for (const Model& block :
       {make_tetrahedral_block({0.06, 0.06, 0.06}, 10, 10, 10, 0.2, 1), make_block({0.06, 0.06, 0.06}, 20, 20, 20)}) {
    Model by_centre = with_material(block), by_group = by_centre;
    const Material hard{50e3, 0.45, 1000};
    const double reached = set_material(by_centre, hard, ball);
    double volume = 0.0, whole = 0.0;
    by_group.add_group("ball", by_group.particles_in(ball));
    set_material(by_group, hard, "ball");
    for (const Cell& cell : by_centre.cells) volume += cell.material == 1 ? cell_volume(block, cell) : 0.0;
    for (const Cell& cell : by_group.cells) whole += cell.material == 1 ? cell_volume(block, cell) : 0.0;
    std::printf("ball of %.2f ml: %.2f ml by centres, %.2f ml wholly in it\n", 1e6 * asked, 1e6 * reached, 1e6 * whole);
    EXPECT_NEAR(reached, volume, 1e-12 * volume);
    EXPECT_NEAR(reached, asked, 0.06 * asked);
    EXPECT_LT(whole, 0.8 * asked);
  }
  // Of cells and of walls as far as they are left.
  Model capsule = with_material(make_tetrahedral_block({0.04, 0.04, 0.04}, 2, 2, 2, 0.0, 1));
  const Material skin{.young = 1e4, .poisson = 0.4, .density = 1000.0, .thickness = 1e-3};
  const auto everywhere = [](const Vec3&) { return true; };
  add_capsule(capsule, skin);
  for (Cell& cell : capsule.cells) cell.share = 0.5;
  EXPECT_NEAR(set_material(capsule, skin, everywhere), 0.5 * 6.0 * 1.6e-6, 1e-15);
  EXPECT_NEAR(set_material(capsule, soft_tissue(), everywhere), 0.5 * 6.4e-5, 1e-15);
  Model strip = make_strip(0.04, 0.04, 4, 4);
  EXPECT_DOUBLE_EQ(set_material(strip, soft_tissue(), [](const Vec3& at) { return at.x() < 0.02; }), 8e-4);
  EXPECT_EQ(message_of([&] { set_material(strip, soft_tissue(), [](const Vec3&) { return false; }); }),
            "set_material: expected the centres of some triangles or quads in the region, but there are none");
}

/// A group that lists cells means these, not all cells between their particles; one that lists faces, and one that
/// lists particles, mean the cells wholly among them.
TEST(Material, GroupsOfCells) {
  Model model = make_tetrahedral_block({0.06, 0.06, 0.06}, 3, 3, 3, 0.2, 1);
  const auto count = static_cast<Index>(model.cells.size());
  const auto add = [&](const char* name, std::vector<Index> cells) {
    model.add_group(name, {});
    model.components.back().cell_refs = std::move(cells);
  };
  std::vector<Index> all_but_one;
  for (Index cell = 1; cell < count; ++cell) all_but_one.push_back(cell);
  add("all but one", all_but_one);
  ASSERT_EQ(model.group("all but one").size(), model.rest.size());
  const std::vector<Index> first = model.cells[0].particles;
  Cell face, other;
  face.type = other.type = CellType::triangle;
  face.particles = {first[0], first[1], first[2]};
  other.particles = {first[1], first[2], first[3]};
  model.cells.push_back(face);
  model.cells.push_back(other);
  add("faces of one", {count, count + 1});
  const Material hard{50e3, 0.45, 1000}, harder{90e3, 0.45, 1000};
  set_material(model, soft_tissue());
  set_material(model, hard, "all but one");
  EXPECT_EQ(model.materials[model.cells[0].material], soft_tissue());
  for (Index cell = 1; cell < count; ++cell) ASSERT_EQ(model.materials[model.cells[cell].material], hard);
  set_material(model, harder, "faces of one");
  EXPECT_EQ(model.materials[model.cells[0].material], harder);
  EXPECT_EQ(model.materials[model.cells[1].material], hard);
  // A group within a group.
  add("inner", {0, 1});
  model.components.back().parent = static_cast<Index>(model.components.size()) - 2;
  set_material(model, soft_tissue(), "faces of one");
  EXPECT_EQ(model.materials[model.cells[1].material], soft_tissue());
  EXPECT_EQ(model.materials[model.cells[2].material], hard);
}

TEST(Material, CantileverAgreesWithTimoshenko) {
  for (double poisson : {0.0, 0.3, 0.45}) {
    const Material tissue = soft_tissue(poisson);
    const Model beam = cantilever(4, tissue);
    const double ratio = cantilever_ratio(beam, build_topology(beam), tissue, Root::beam);
    std::printf("cantilever of four cells across, nu %.2f: %.4f\n", poisson, ratio);
    EXPECT_NEAR(ratio, 1.0, 0.03) << "nu " << poisson;
  }
}

TEST(Material, AveragedEnergyDoesNotConverge) {
  const Material tissue = soft_tissue();
  double ratio[2];
  for (int k = 0; k < 2; ++k) {
    const Model beam = cantilever(2 << k, tissue);
    ratio[k] = cantilever_ratio(beam, averaged_tables(beam), tissue, Root::beam);
    std::printf("cantilever n = %d, averaged energy: %.3f\n", 2 << k, ratio[k]);
  }
  EXPECT_GT(ratio[1], 2.0 * ratio[0]);  // softer and softer: the deflection runs away from 1
  EXPECT_GT(ratio[1], 2.0);
}

}  // namespace
}  // namespace phymul::test
