// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/index_table.h"
#include "model/file_extras.h"
#include "support/pml_text.h"

namespace phymul {
namespace {

TEST(PmlRoundTrip, Samples) {
  for (const std::string& path : {test_data + "/tetrahedron_4.pml", sample_data + "/cylinder_275.pml"}) {
    const Model model = read_pml(path);
    const Model again = reread(model);
    EXPECT_EQ(again, model) << path;
    EXPECT_EQ(written(again), written(model)) << path;
  }
}

TEST(PmlRoundTrip, BuiltShapes) {
  const std::vector<Model> shapes = {make_tetrahedron(0.01),
                                     make_block({0.03, 0.02, 0.05}, 3, 2, 4),
                                     make_block({0.03, 0.02, 0.05}, 3, 2, 4, 26),
                                     make_cylinder(0.01, 0.05, 2, 8, 5),
                                     make_strip(0.05, 0.01, 6, 2),
                                     make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 7)};
  for (const Model& shape : shapes) {
    const Model again = reread(shape);
    EXPECT_EQ(again, shape) << shape.name;
    EXPECT_EQ(again.dimension, shape.dimension);
  }
}

TEST(PmlRoundTrip, Materials) {
  Model model = make_block({0.03, 0.02, 0.05}, 3, 2, 4);
  set_material(model, {3e3, 0.45, 1100});
  EXPECT_EQ(reread(model), model);
  model.add_group("half", model.particles_in([](const Vec3& X) { return X.z() > 0.02; }));
  set_material(model, {1e6, 0.3, 1000}, "half");
  ASSERT_EQ(model.materials.size(), 2u);
  EXPECT_EQ(reread(model), model);
  Model sample = read_pml(sample_data + "/cylinder_275.pml");
  set_material(sample, {1e4 / 3, 0.49, 1049.7});
  EXPECT_EQ(reread(sample), sample);
}

TEST(PmlRoundTrip, SpareParticlesAreLeftOut) {
  Model block = make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 7);
  set_material(block, {3e3, 0.45, 1100});
  EXPECT_EQ(reread(with_spare_particles(block, 5)), block);
  const auto with_all = [](Model model) {
    model.add_group("all", model.particles_in([](const Vec3&) { return true; }));
    return model;
  };
  Model spare = with_all(block);
  const auto first = block.particle_count();
  spare = with_spare_particles(std::move(spare), 5);
  for (Index i = first; i < spare.particle_count(); ++i) spare.components.back().particles.push_back(i);
  EXPECT_EQ(reread(spare), with_all(block));
}

/// A part of a cut cell is a cell with its share, and a removed cell is there.
TEST(PmlRoundTrip, CutAndRemovedCells) {
  Model block = make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 7);
  set_material(block, {3e3, 0.45, 1100});
  const Model sheet =
      make_wall({.vertices = {{0, 0, 0}, {0.03, 0, 0}, {0.03, 0.03, 0}, {0, 0.03, 0}},
                 .triangles = {{0, 1, 2}, {0, 2, 3}},
                 .notes = {}},
                {.spacing = 0.01, .material = {.young = 3e3, .poisson = 0.45, .density = 1100, .thickness = 1e-3}});
  for (const Model& whole : {block, sheet}) {
    Model cut = cut_body(whole, cut_plane({0.014, 0.0, 0.0}, {1.0, 0.3, 0.1}));
    cut.cells[3].share = 0.0;
    ASSERT_GT(cut.cells.size(), whole.cells.size());
    const Model again = reread(cut);
    EXPECT_EQ(again, cut);
    EXPECT_EQ(again.cells, cut.cells);
  }
}

/// Particles of which a simulation has removed all cells have no mass, and are among the others.
TEST(PmlRoundTrip, ParticlesWithoutACell) {
  Model block = make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 7);
  set_material(block, {3e3, 0.45, 1100});
  Simulation sim(std::move(block), {.backend = "reference"});
  sim.remove_cells(sim.model().cells_in([](const Vec3& x) { return x.norm() < 0.02; }));
  ASSERT_GT(std::ranges::count(sim.model().mass, 0.0), 0);
  EXPECT_EQ(reread(sim.model()), sim.model());
}

TEST(PmlRoundTrip, UnknownAttributesNamesAndColours) {
  std::vector<std::string> atoms = tetrahedron_atoms;
  atoms[2] =
      R"(<atom><atomProperties index="2" x="0" y="1" z="0" name="tip &lt;&amp;&quot;&#10;" fixed="1" b="&#9;"/></atom>)";
  const std::string colour = "<color r=\"0.1\" g=\"0.2\" b=\"0.3\" a=\"0.4\"/>";
  const std::string neighbourhood =
      "<structuralComponent name=\"Neighborhoods\" stiffness=\"2\" zeta=\"0.1\">" + colour +
      cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\" index=\"50\" eta=\"x\"", colour) +
      cell_text("POLY_VERTEX", {0, 2, 3}, "name=\"Atom #3\" stiffness=\"4\"") +
      "</structuralComponent>\n</multiComponent></exclusiveComponents>";
  std::string text =
      pml_text(atoms, {colour, cell_text("TETRAHEDRON", {0, 1, 2, 3}, "index=\"4\" name=\"c\" odd=\"'\"", colour)}, "",
               "comment=\"root &gt; all\"");
  text = replaced(text, "name=\"list\"", "name=\"list\" mode=\"POINTS\"");
  text = replaced(text, "<multiComponent name=\"Exclusive Components\"",
                  "<multiComponent name=\"Exclusive Components\" level=\"1\"");
  text = replaced(text, "name=\"Elements\"", "name=\"Elements\" mode=\"SURFACE\" unit=\"\"");
  text = replaced(text, "</multiComponent></exclusiveComponents>", neighbourhood);
  const Model model = read_pml_text(text, "t.pml");
  const FileExtras& extras = extras_of(model);
  EXPECT_EQ(extras.attributes, (std::vector<Attribute>{{"comment", "root > all"}}));
  EXPECT_EQ(extras.atom_list.attributes, (std::vector<Attribute>{{"mode", "POINTS"}}));
  ASSERT_EQ(extras.particle_name.size(), 4u);
  EXPECT_EQ(extras.particle_name[2], "tip <&\"\n");
  EXPECT_EQ(extras.particle_fields[2], (std::vector<Attribute>{{"fixed", "1"}, {"b", "\t"}}));
  EXPECT_EQ(model.components[1].attributes, (std::vector<Attribute>{{"mode", "SURFACE"}, {"unit", ""}}));
  EXPECT_EQ(model.components[1].colour, (Colour{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(model.cells[0].attributes, (std::vector<Attribute>{{"odd", "'"}}));
  EXPECT_EQ(model.stiffness, (std::vector<double>{2, 2, 2, 4}));
  EXPECT_EQ(extras.neighbourhood_index, (std::vector<Index>{50, -1, -1, -1}));
  ASSERT_EQ(extras.neighbourhood_fields.size(), 2u);
  EXPECT_EQ(extras.neighbourhood_fields[1].attributes, (std::vector<Attribute>{{"stiffness", "4"}}));
  const Model again = reread(model);
  EXPECT_EQ(again, model);
  EXPECT_EQ(extras_of(again), extras);
  EXPECT_EQ(again.components, model.components);
}

TEST(PmlRoundTrip, RowsInAnotherOrderThanTheFileNeeds) {
  Model model = make_block({0.03, 0.02, 0.05}, 3, 2, 2);
  model.components.clear();
  Component first, second;
  for (Index i = 0; i < static_cast<Index>(model.cells.size()); ++i) (i % 2 == 0 ? second : first).cells.push_back(i);
  first.name = "first";
  second.name = "second";
  // A group before the body, two roots, a cell in no component, references to cells without an index.
  model.add_group("group", {1, 5});
  model.components.push_back(first);
  model.components.push_back(second);
  model.components[1].cell_refs = {3, 0};
  model.components[2].cells.pop_back();
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  EXPECT_EQ(reread(model), model);
  // Neighbours that are not those of the cells, though no component lists them.
  model.neighbours = {};
  for (Index i = 0; i < model.particle_count(); ++i) {
    const Index other[3] = {(i + 1) % model.particle_count(), (i + 7) % model.particle_count(),
                            (i + 3) % model.particle_count()};
    model.neighbours.push_row(other, other + 3);
  }
  EXPECT_EQ(reread(model), model);
  EXPECT_EQ(reread(reread(model)), model);
}

TEST(PmlRoundTrip, OneCellInTwoComponentsBecomesAReference) {
  Model model = make_tetrahedron(0.01);
  model.components.clear();
  Component a, b;
  a.name = "a";
  b.name = "b";
  a.cells = b.cells = {0};
  model.components = {a, b};
  const Model again = reread(model);
  ASSERT_EQ(again.components.size(), 2u);
  EXPECT_EQ(again.components[1].cell_refs, std::vector<Index>{0});
  EXPECT_EQ(again.group("b"), model.group("b"));
}

TEST(PmlWrite, RefusesWhatPmlCannotSay) {
  const Model model = read_pml(test_data + "/tetrahedron_4.pml");
  Model twice = model;
  change_extras(twice, [](FileExtras& e) { e.particle_index[3] = 0; });
  EXPECT_EQ(message_of([&] { written(twice); }),
            "particle 3: expected a file index of its own, got 0, which particle 0 has");
  const auto refused = [&](const char* part, auto change) {
    Model broken = model;
    change(broken);
    EXPECT_TRUE(refuses([&] { written(broken); }, part));
  };
  const auto refused_extras = [&](const char* part, auto change) {
    refused(part, [&](Model& m) { change_extras(m, change); });
  };
  refused_extras("<physicalModel> under other names than its own, got \"name\"", [](FileExtras& e) {
    e.attributes = {{"name", "again"}};
  });
  refused_extras("a name that XML allows for an attribute", [](FileExtras& e) { e.attributes = {{"two words", ""}}; });
  refused("control character 7", [](Model& m) { m.name = "bell \a"; });
  refused("component 1", [](Model& m) { m.components[1].parent = 2; });
  refused("finite coordinates", [](Model& m) { m.rest[0].x() = std::nan(""); });
  EXPECT_TRUE(refuses([&] { written(model, {.length_unit = 0}); }, "positive length_unit"));
}

TEST(PmlWrite, ReplacesAFileOnlyByACompleteOne) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "phymul_pml_write";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "body.pml").string();
  Model model = read_pml(test_data + "/tetrahedron_4.pml");
  write_pml(model, path);
  EXPECT_EQ(read_pml(path), model);
  Model broken = model;
  change_extras(broken, [](FileExtras& e) {
    e.particle_fields.assign(4, {});
    e.particle_fields[3] = {{"not a name", ""}};
  });
  EXPECT_EQ(message_of([&] { write_pml(broken, path); }).rfind(path + ": ", 0), 0u);
  EXPECT_EQ(read_pml(path), model) << "the old file stays";
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++files;
  EXPECT_EQ(files, 1u) << "no draft is left behind";
  const std::string nowhere = (folder / "no" / "body.pml").string();
  EXPECT_EQ(message_of([&] { write_pml(model, nowhere); }),
            nowhere + ": cannot be written; check that its folder exists and may be written to");
  std::filesystem::remove_all(folder);
}

TEST(PmlWrite, SaysWhenTheStreamFails) {
  std::ofstream full("/dev/full");
  if (!full) GTEST_SKIP() << "no /dev/full here";
  const Model model = read_pml(sample_data + "/cylinder_275.pml");
  EXPECT_EQ(message_of([&] { write_pml(model, full); }), "the output stream failed; is the disk full?");
}

// What a model's components, numbers and materials become in a file, and what no file can hold.

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
