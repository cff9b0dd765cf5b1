// SPDX-License-Identifier: MIT
//
// What a model's components, numbers and materials become in a file, and what no file can hold.
#include <phymul/pml.h>
#include <phymul/shapes.h>

#include "base/index_table.h"
#include "model/file_extras.h"
#include "support/pml_text.h"

namespace phymul {
namespace {

/// A body whose root component, row 0, holds "Elements", row 1.
Model body() {
  return make_block({0.02, 0.01, 0.01}, 2, 1, 1);
}

void expect_refused(const Model& model, const std::string& part) {
  EXPECT_TRUE(refuses([&] { written(model); }, part));
}

TEST(PmlLayout, ComponentsThatNoFileHolds) {
  Model model = body();
  model.components[1].exclusive = false;
  expect_refused(model, "component 1 \"Elements\": expected the same `exclusive` as its parent's");
  model = body();
  model.components[0].particles = {1};
  expect_refused(model, "expected cells and particles in structural components only");
  model = body();
  model.components[1].name = "Neighborhoods";
  model.cells[0].name = "Atom #3";
  expect_refused(model, "got a cell named \"Atom #3\"");
  model = body();
  for (Index depth = 0; depth < 300; ++depth) {
    const Component inner{.parent = depth == 0 ? 0 : static_cast<Index>(model.components.size()) - 1,
                          .structural = false};
    model.components.push_back(inner);
  }
  expect_refused(model, "expected components nested at most 200 deep");
}

TEST(PmlLayout, CountsAreTrue) {
  EXPECT_TRUE(says(written(body()), "nrOfCells=\"2\""));
  const Model model =
      read_pml_text(with_neighbourhoods({cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\"")}), "t");
  EXPECT_TRUE(says(written(model), "nrOfCells=\"4\""));
}

TEST(PmlLayout, NewCellNumbersAreNobodyElses) {
  Model model = body();
  change_extras(model, [](FileExtras& extras) { extras.cell_index = {5}; });
  model.add_group("front", {});
  model.components.back().cell_refs = {1};
  EXPECT_EQ(reread(model), model);
  EXPECT_TRUE(says(written(model), "<cellRef index=\"6\"/>"));
  change_extras(model, [&](FileExtras& extras) {
    extras.neighbourhood_index.assign(model.rest.size(), -1);
    extras.neighbourhood_index[2] = 50;
  });
  EXPECT_TRUE(says(written(model), "<cellRef index=\"51\"/>"));
}

TEST(PmlLayout, MaterialBesideAnAttributeOfItsName) {
  Model model = body();
  set_material(model, {1e4, 0.3, 1000});
  model.components[1].attributes = {{"young", "1"}};
  EXPECT_EQ(reread(model), model);
}

TEST(PmlRead, RowsOfComponentsHaveParentsFirst) {
  std::string text = pml_text(tetrahedron_atoms, {tetrahedron_cell});
  text = replaced(text, "name=\"Exclusive Components\"", "name=\"Exclusive Components\" phymul=\"row=1\"");
  text = replaced(text, "name=\"Elements\"", "name=\"Elements\" phymul=\"row=0\"");
  EXPECT_TRUE(refuses([&] { read_pml_text(text, "t"); }, "row=N of every component"));
}

TEST(PmlRead, Colours) {
  const auto colour_of = [](const std::string& parts, std::vector<std::string>& notes) {
    const Model model = read_pml_text(pml_text(tetrahedron_atoms, {"<color " + parts + "/>", tetrahedron_cell}), "t");
    notes = model.notes;
    return model.components[1].colour;
  };
  std::vector<std::string> notes;
  EXPECT_EQ(colour_of("r=\"0.1\" g=\"0\" b=\"1\"", notes), (Colour{0.1, 0.0, 1.0, 1.0}));
  EXPECT_EQ(colour_of("r=\"255\" g=\"0\" b=\"1\"", notes), std::nullopt);
  EXPECT_TRUE(has_note(notes, "this colour is left out"));
}

TEST(PmlRead, TextsHaveALimitToo) {
  EXPECT_TRUE(refuses([&] { read_pml_text(pml_text(tetrahedron_atoms, {tetrahedron_cell}), "t", {.max_bytes = 100}); },
                      "expected at most 100 bytes"));
}

TEST(IndexTable, NegativeNumbersNameNothing) {
  const IndexTable table({5, -1, 9});
  EXPECT_EQ(table.find(9), 2);
  EXPECT_EQ(table.find(-1), -1);
}

}  // namespace
}  // namespace phymul
