// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <algorithm>
#include <clocale>
#include <locale>

#include "model/file_extras.h"
#include "support/pml_text.h"

namespace phymul {
namespace {

std::vector<Index> row(const RaggedList& list, Index i) {
  return {list.begin(i), list.end(i)};
}

TEST(PmlRead, Tetrahedron) {
  const Model model = read_pml(test_data + "/tetrahedron_4.pml");
  EXPECT_EQ(model.name, "tetrahedron");
  EXPECT_EQ(model.dimension, 3);
  ASSERT_EQ(model.particle_count(), 4);
  EXPECT_EQ(model.rest[1], Vec3(1e-3, 0, 0));
  EXPECT_EQ(model.rest[3], Vec3(0.5e-3, 0.000288675135, 0.000816496581));
  EXPECT_EQ(model.mass, std::vector<double>(4, 1.0));
  EXPECT_EQ(model.stiffness, std::vector<double>(4, 1.0));
  EXPECT_EQ(extras_of(model).particle_index, (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(row(model.neighbours, 2), (std::vector<Index>{0, 1, 3}));
  ASSERT_EQ(model.cells.size(), 1u);
  EXPECT_EQ(model.cells[0].type, CellType::tetrahedron);
  EXPECT_EQ(model.cell_file_index(0), 0);
  ASSERT_EQ(model.components.size(), 5u);
  EXPECT_EQ(model.components[0].name, "Exclusive Components");
  EXPECT_FALSE(model.components[0].structural);
  EXPECT_EQ(model.components[1].cells, std::vector<Index>{0});
  EXPECT_EQ(model.components[2].name, "Neighborhoods");
  EXPECT_EQ(model.components[2].attributes, (std::vector<Attribute>{{"stiffness", "1"}}));
  EXPECT_TRUE(model.components[2].cells.empty());
  EXPECT_EQ(model.components[4].parent, 3);
  EXPECT_FALSE(model.components[4].exclusive);
  EXPECT_TRUE(extras_of(model).particle_name.empty());
  EXPECT_TRUE(extras_of(model).particle_fields.empty());
}

TEST(PmlRead, Cylinder) {
  const Model model = read_pml(sample_data + "/cylinder_275.pml");
  EXPECT_EQ(model.particle_count(), 275);
  EXPECT_EQ(model.cells.size(), 240u);
  EXPECT_EQ(model.neighbours.rows(), 275);
  EXPECT_EQ(row(model.neighbours, 274), (std::vector<Index>{273, 266, 249, 267}));
  std::vector<Index> disc(25);
  for (Index i = 0; i < 25; ++i) disc[i] = i;
  EXPECT_EQ(model.group("Fixed Dof"), disc);
  EXPECT_DOUBLE_EQ(body_size(model), 0.04);
}

TEST(PmlRead, LengthUnit) {
  EXPECT_EQ(read_pml(test_data + "/tetrahedron_4.pml", {.length_unit = 1.0}).rest[1], Vec3(1, 0, 0));
}

TEST(PmlRead, MassAndStiffnessAtomThenCellThenComponentThenDefault) {
  std::vector<std::string> cells;
  for (int i = 0; i < 4; ++i) {
    const std::string own = i == 0 || i == 1 ? " mass=\"20\" stiffness=\"200\"" : "";
    if (i < 3)
      cells.push_back(cell_text("POLY_VERTEX", {(i + 1) % 4}, "name=\"Atom #" + std::to_string(i) + "\"" + own));
  }
  const std::string component = with_neighbourhoods(cells, "mass=\"30\" stiffness=\"300\"");
  const Model model =
      read_pml_text(replaced(component, "z=\"0\"/>", "z=\"0\" mass=\"10\" stiffness=\"100\"/>"), "t.pml");
  EXPECT_EQ(model.mass, (std::vector<double>{10, 20, 30, 30}));
  EXPECT_EQ(model.stiffness, (std::vector<double>{100, 200, 300, 300}));
  const PmlOptions defaults{.default_mass = 0.5, .default_stiffness = 7};
  const Model bare = read_pml_text(pml_text(tetrahedron_atoms, {tetrahedron_cell}), "t.pml", defaults);
  EXPECT_EQ(bare.mass, std::vector<double>(4, 0.5));
  EXPECT_EQ(bare.stiffness, std::vector<double>(4, 7.0));
}

/// A kilogram a particle and a newton a metre are nobody's tissue, and would move like none without a word.
TEST(PmlRead, DefaultMassesAndStiffnessesAreNoted) {
  const Model bare = read_pml_text(pml_text(tetrahedron_atoms, {tetrahedron_cell}), "t.pml", {.default_mass = 0.5});
  EXPECT_TRUE(has_note(bare.notes, "t.pml:1: 4 of 4 atom(s) have no mass: 0.5 kg each is assumed"));
  EXPECT_TRUE(has_note(bare.notes, "t.pml:1: 4 of 4 atom(s) have no stiffness: 1 N/m each is assumed"));
  const std::string cell = cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\" mass=\"20\" stiffness=\"200\"");
  const Model some = read_pml_text(with_neighbourhoods({cell}), "t.pml");
  EXPECT_TRUE(has_note(some.notes, "3 of 4 atom(s) have no mass: 1 kg each"));
  EXPECT_TRUE(has_note(some.notes, "3 of 4 atom(s) have no stiffness"));
  const Model all = read_pml_text(with_neighbourhoods({cell}, "mass=\"30\" stiffness=\"300\""), "t.pml");
  EXPECT_FALSE(has_note(all.notes, "have no mass"));
  EXPECT_FALSE(has_note(all.notes, "have no stiffness"));
  // With a material no computation looks at the stiffness.
  const std::string material = cell_text("TETRAHEDRON", {0, 1, 2, 3}, "young=\"5e3\" poisson=\"0.3\" density=\"1e3\"");
  const Model tissue = read_pml_text(pml_text(tetrahedron_atoms, {material}), "t.pml");
  ASSERT_EQ(tissue.materials.size(), 1u);
  EXPECT_TRUE(has_note(tissue.notes, "have no mass"));
  EXPECT_FALSE(has_note(tissue.notes, "have no stiffness"));
}

TEST(PmlRead, NeighboursFromCellsWhereTheFileHasNone) {
  const Model model = read_pml_text(pml_text(tetrahedron_atoms, {tetrahedron_cell}), "t.pml");
  EXPECT_EQ(row(model.neighbours, 0), (std::vector<Index>{1, 2, 3}));
  EXPECT_EQ(row(model.neighbours, 3), (std::vector<Index>{0, 1, 2}));
}

TEST(PmlRead, MissingNeighbourhoodIsAnEmptyRowAndANote) {
  const Model model =
      read_pml_text(with_neighbourhoods({cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\"")}), "t.pml");
  EXPECT_EQ(model.neighbours.size(0), 3);
  for (Index i = 1; i < 4; ++i) EXPECT_EQ(model.neighbours.size(i), 0);
  EXPECT_TRUE(has_note(model.notes, "t.pml:10: 3 atom(s) have no neighbourhood and get no neighbours: 1, 2, 3"));
}

TEST(PmlRead, FewNeighboursAreNamedAndLoad) {
  const std::string text = with_neighbourhoods({cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\""),
                                                cell_text("POLY_VERTEX", {0, 2}, "name=\"Atom #1\""),
                                                cell_text("POLY_VERTEX", {0, 1, 3}, "name=\"Atom #2\""),
                                                cell_text("POLY_VERTEX", {0, 1, 2}, "name=\"Atom #3\"")});
  const Model model = read_pml_text(text, "t.pml");
  EXPECT_EQ(row(model.neighbours, 1), (std::vector<Index>{0, 2}));
  const std::vector<Finding> findings = find_flaws(model);
  const auto few = std::find_if(findings.begin(), findings.end(),
                                [](const Finding& finding) { return finding.flaw == Flaw::few_neighbours; });
  ASSERT_NE(few, findings.end());
  EXPECT_EQ(few->items, std::vector<Index>{1});
  EXPECT_TRUE(has_note(model.notes, "t.pml: " + few->message));
  // What becomes of the particle is the caller's choice.
  EXPECT_TRUE(refuses([&] { build_topology(model); }, "on_sparse"));
  for (const SparseParticle choice : {SparseParticle::springs, SparseParticle::free}) {
    EXPECT_EQ(message_of([&] { build_topology(model, {.on_sparse = choice}); }), "(no error)");
  }
}

TEST(PmlRead, IndicesAreLookedUpNotCounted) {
  std::vector<std::string> atoms = tetrahedron_atoms;
  atoms[0] = replaced(atoms[0], "index=\"0\"", "index=\"100\"");
  atoms[1] = replaced(atoms[1], "index=\"1\"", "index=\"7\"");
  const Model model =
      read_pml_text(pml_text(atoms, {cell_text("TETRAHEDRON", {100, 7, 2, 3}, "index=\"40\"")}), "t.pml");
  EXPECT_EQ(extras_of(model).particle_index, (std::vector<Index>{100, 7, 2, 3}));
  EXPECT_EQ(model.cells[0].particles, (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_EQ(reread(model), model);
}

TEST(PmlRead, CellReferenceBeforeItsCell) {
  const std::string group =
      "<informativeComponents><multiComponent name=\"I\"><structuralComponent name=\"G\"><cellRef index=\"9\"/>"
      "<atomRef index=\"0\"/></structuralComponent></multiComponent></informativeComponents>\n";
  std::string text = pml_text(tetrahedron_atoms,
                              {"<cellRef index=\"9\"/>", cell_text("TETRAHEDRON", {0, 1, 2, 3}, "index=\"9\"")}, group);
  const Model model = read_pml_text(text, "t.pml");
  EXPECT_EQ(model.components[1].cell_refs, std::vector<Index>{0});
  EXPECT_EQ(model.components[1].cells, std::vector<Index>{0});
  EXPECT_EQ(model.components[3].cell_refs, std::vector<Index>{0});
  EXPECT_EQ(model.components[3].particles, std::vector<Index>{0});
  EXPECT_EQ(model.group("G"), (std::vector<Index>{0, 1, 2, 3}));
  EXPECT_TRUE(says(written(model), "<cellRef index=\"9\"/>"));
  EXPECT_EQ(reread(model), model);
}

TEST(PmlRead, EmptyInformativeComponents) {
  for (const char* const empty : {"<informativeComponents/>", "<informativeComponents></informativeComponents>", ""}) {
    const Model model = read_pml_text(pml_text(tetrahedron_atoms, {tetrahedron_cell}, empty), "t.pml");
    EXPECT_EQ(model.components.size(), 2u);
    EXPECT_EQ(reread(model), model);
  }
}

TEST(PmlRead, UnknownElementsAreSkippedWithOneNote) {
  const Model model = read_pml_text(
      pml_text(tetrahedron_atoms, {"<spring k=\"1\"><a/></spring>", "<spring/>", tetrahedron_cell}, "<future/>"),
      "t.pml");
  EXPECT_EQ(model.cells.size(), 1u);
  EXPECT_TRUE(
      has_note(model.notes, "t.pml:11: unknown element <spring> in <structuralComponent> was skipped, and 1 more"));
  EXPECT_TRUE(has_note(model.notes, "t.pml:16: unknown element <future> in <physicalModel> was skipped"));
}

TEST(PmlRead, CountsAreHintsOnly) {
  const Model model =
      read_pml_text(replaced(pml_text(tetrahedron_atoms, {"<nrOfStructures value=\"2000000000\"/>", tetrahedron_cell},
                                      "", "nrOfAtoms=\"1000000000\" nrOfCells=\"-3\""),
                             "<atom>", "<nrOfStructures value=\"1000000000\"/><atom>"),
                    "t.pml");
  EXPECT_EQ(model.particle_count(), 4);
  EXPECT_TRUE(extras_of(model).attributes.empty());
}

TEST(PmlRead, AcceptsSignsAndBlanksAroundNumbers) {
  std::vector<std::string> atoms = tetrahedron_atoms;
  atoms[1] = R"(<atom><atomProperties index=" +1" x=" +1e0 " y="-0" z="0."/></atom>)";
  EXPECT_EQ(read_pml_text(pml_text(atoms, {tetrahedron_cell}), "t.pml").rest[1], Vec3(1e-3, 0, 0));
}

TEST(PmlRead, DecimalPointWhateverTheLocale) {
  class Comma : public std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Model plain = read_pml(sample_data + "/cylinder_275.pml");
  const std::string text = written(plain);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  for (const char* const name : {"de_DE.UTF-8", "fr_FR.UTF-8"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
  }
  EXPECT_EQ(read_pml(sample_data + "/cylinder_275.pml"), plain);
  EXPECT_EQ(written(plain), text);
  std::locale::global(before);
  std::setlocale(LC_NUMERIC, "C");
}

TEST(PmlRead, Latin1NamesAndByteOrderMark) {
  const std::string text = pml_text(tetrahedron_atoms, {tetrahedron_cell});
  const std::string latin1 =
      "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>" + replaced(text, "name=\"t\"", "name=\"t\xEAte\"");
  EXPECT_EQ(read_pml_text(latin1, "t.pml").name, "t\xC3\xAAte");
  // A name of a mesh file that is not UTF-8 is written as if it were Latin-1; what is UTF-8 stays.
  Model named = read_pml_text(text, "t.pml");
  named.name = "t\xEAte\xC0\xAF \xC3\xAA \xE2\x82\xAC\xF0\x9F\x98\x80\xED\xA0\x80\xE2\x82";
  EXPECT_EQ(
      read_pml_text(written(named), "t.pml").name,
      "t\xC3\xAAte\xC3\x80\xC2\xAF \xC3\xAA \xE2\x82\xAC\xF0\x9F\x98\x80\xC3\xAD\xC2\xA0\xC2\x80\xC3\xA2\xC2\x82");
  EXPECT_EQ(read_pml_text("\xEF\xBB\xBF" + text, "t.pml").name, "t");
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(read_pml_text(windows, "t.pml"), read_pml_text(text, "t.pml"));
}

TEST(PmlRead, MaterialOfCellThenOfComponent) {
  const std::string soft = "young=\"1000\" poisson=\"0.45\" density=\"1100\"";
  const std::string stiff = "young=\"5e4\" poisson=\"0.3\" density=\"1000\"";
  const std::string text = replaced(
      pml_text(tetrahedron_atoms, {tetrahedron_cell, cell_text("TETRAHEDRON", {0, 1, 2, 3}, stiff), tetrahedron_cell}),
      "name=\"Elements\"", "name=\"Elements\" " + soft);
  const Model model = read_pml_text(text, "t.pml");
  ASSERT_EQ(model.materials, (std::vector<Material>{{1000, 0.45, 1100}, {5e4, 0.3, 1000}}));
  EXPECT_EQ(model.cells[0].material, 0);
  EXPECT_EQ(model.cells[1].material, 1);
  EXPECT_EQ(model.cells[2].material, 0);
  EXPECT_EQ(model.mass, std::vector<double>(4, 1.0)) << "masses are those of the file, not computed anew";
  EXPECT_EQ(reread(model), model);
}

TEST(PmlRead, PartOfAMaterialIsNoneButStays) {
  const Model model = read_pml_text(
      pml_text(tetrahedron_atoms, {cell_text("TETRAHEDRON", {0, 1, 2, 3}, "young=\"1000\" poisson=\"0.45\"")}),
      "t.pml");
  EXPECT_TRUE(model.materials.empty());
  EXPECT_EQ(model.cells[0].attributes, (std::vector<Attribute>{{"young", "1000"}, {"poisson", "0.45"}}));
  EXPECT_TRUE(has_note(model.notes, "t.pml:11: expected young (Pa), poisson and density (kg/m^3) together"));
  EXPECT_EQ(reread(model), model);
}

}  // namespace
}  // namespace phymul
