// SPDX-License-Identifier: MIT
//
// check_mesh(): cells that overlap their neighbours, however their vertices are ordered.
#include <gtest/gtest.h>
#include <phymul/check.h>
#include <phymul/shapes.h>

#include <algorithm>

#include "support/flaws.h"
#include "support/message_of.h"

namespace phymul {
namespace {

/// A vertex pushed through its neighbours is no matter of winding: turned round, cells would lie one in the other.
TEST(TangledCells, AreRefused) {
  const Model whole = make_tetrahedral_block({0.04, 0.04, 0.04}, 4, 4, 4, 0.1, 3);
  const Model flat = make_strip(0.04, 0.04, 4, 4);
  for (const Model& model : {whole, flat}) {
    Model tangled = model;
    const auto inner = std::ranges::min_element(tangled.rest, {}, [&](const Vec3& p) {
      return (p - Vec3(0.02, 0.02, model.dimension == 3 ? 0.02 : 0.0)).norm();
    });
    inner->x() += 0.026;
    const std::vector<Finding> findings = find_flaws(tangled);
    EXPECT_TRUE(has(findings, Flaw::tangled));
    EXPECT_FALSE(has(findings, Flaw::winding));
    const Model before = tangled;
    const std::string message = message_of([&] { check_mesh(tangled, "liver.msh"); });
    EXPECT_TRUE(message.starts_with("liver.msh: ")) << message;
    EXPECT_TRUE(says(message, "whatever the order of the vertices"));
    EXPECT_TRUE(tangled == before);
    // The same cells listed mirrored, in part or all, are only wound the wrong way.
    for (const std::size_t every : {1, 3}) {
      Model mirrored = model;
      for (std::size_t row = 0; row < mirrored.cells.size(); row += every) {
        mirror(mirrored.cells[row]);
      }
      EXPECT_TRUE(has(find_flaws(mirrored), Flaw::winding)) << every;
      check_mesh(mirrored);
      EXPECT_TRUE(find_flaws(mirrored).empty()) << every;
    }
  }
}

/// In a file that is wound the wrong way throughout, the one cell that is not is the one to name.
TEST(TangledCells, AreTheOnesThatLieWrong) {
  Model model = make_tetrahedral_block({0.04, 0.04, 0.04}, 4, 4, 4, 0.1, 3);
  const std::vector<Index> corner = model.cells[200].particles;
  const Vec3 face = (model.rest[corner[1]] + model.rest[corner[2]] + model.rest[corner[3]]) / 3.0;
  model.rest.push_back(model.rest[corner[0]] + 1.2 * (face - model.rest[corner[0]]));  // beyond the face
  model.mass.push_back(1.0);
  model.stiffness.push_back(1.0);
  model.cells[200].particles = {static_cast<Index>(model.rest.size()) - 1, corner[1], corner[2], corner[3]};
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  for (Cell& cell : model.cells) mirror(cell);
  for (const Finding& finding : find_flaws(model)) {
    if (finding.flaw == Flaw::tangled) {
      EXPECT_TRUE(std::ranges::count(finding.items, 200) == 1) << finding.message;
    }
  }
  EXPECT_TRUE(has(find_flaws(model), Flaw::tangled));
}

TEST(TangledCells, ACellAndItsMirroredDuplicateAreNone) {
  Model model = make_tetrahedron(0.01);
  model.cells.push_back(model.cells.front());
  mirror(model.cells.back());
  EXPECT_FALSE(has(find_flaws(model), Flaw::tangled));
  EXPECT_TRUE(has(find_flaws(model), Flaw::winding));
  EXPECT_TRUE(has(find_flaws(model), Flaw::duplicate_cell));
}

}  // namespace
}  // namespace phymul
