// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/bodies.h>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

const Vec3 beam(0.2, 0.05, 0.05);

std::vector<std::string> notes(Model model) {
  set_material(model, soft_tissue(0.3));
  return build_topology(model).notes;
}

/// Slivers among good cells are no stretch.
TEST(StretchedCells, GoodMeshesAreNotNamed) {
  for (const Model& model :
       {make_block(beam, 16, 4, 4), make_block({0.2, 0.06, 0.05}, 4, 3, 3), make_cylinder(0.02, 0.1, 2, 8, 10),
        make_tetrahedral_block(beam, 16, 4, 4, 0.45, 1, 0.02), make_strip(0.2, 0.1, 8, 8)}) {
    EXPECT_TRUE(notes(model).empty()) << model.name << ": " << notes(model).front();
  }
}

TEST(StretchedCells, TheBodyIsNamedWithItsStretch) {
  const Model cube = make_block({0.05, 0.05, 0.05}, 4, 4, 4), rod = moved(make_block(beam, 4, 4, 4), {0, 0.1, 0});
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
  Model turned = make_block(beam, 4, 4, 4);
  for (Vec3& x : turned.rest) x = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * x;
  for (const Model& model : {turned, make_tetrahedral_block(beam, 4, 4, 4, 0.2, 1), make_strip(0.2, 0.05, 4, 4)}) {
    const auto found = notes(model);
    ASSERT_EQ(found.size(), 1u) << model.name;
    EXPECT_TRUE(says(found.front(), ": its cells are 4."));
  }
}

}  // namespace
}  // namespace phymul::test
