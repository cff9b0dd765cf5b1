// SPDX-License-Identifier: MIT
//
// tests/data/mesh holds one mesh of every cell type, in files that Gmsh 4.8 and VTK 9.1 wrote from mixed_41.msh.
#include <gtest/gtest.h>
#include <phymul/error.h>
#include <phymul/mesh.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "io/mesh/mesh_parts.h"
#include "model/file_extras.h"
#include "support/message_of.h"
#include "support/text_file.h"

namespace {

using phymul::CellType;
using phymul::Index;
using phymul::Model;

std::string data(const std::string& name) {
  return std::string(PHYMUL_TEST_DATA) + "/mesh/" + name;
}

/// Reads text as a file of that name; what read_mesh throws comes out as its message.
std::string message_of(const std::string& name, const std::string& text) {
  try {
    phymul::mesh_from_bytes(name, text, {});
  } catch (const phymul::Error& error) {
    return error.what();
  }
  return "loaded";
}

Model read_text(const std::string& name, const std::string& text) {
  return phymul::mesh_from_bytes(name, text, {});
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

std::set<std::pair<CellType, std::vector<Index>>> cell_set(const Model& model) {
  std::set<std::pair<CellType, std::vector<Index>>> cells;
  for (const phymul::Cell& cell : model.cells) cells.emplace(cell.type, cell.particles);
  return cells;
}

const char* const variants[] = {"mixed_41.msh",         "mixed_41_binary.msh",    "mixed_22.msh",
                                "mixed_22_binary.msh",  "mixed_42.vtk",           "mixed_42_binary.vtk",
                                "mixed_51.vtk",         "mixed_51_binary.vtk",    "mixed_ascii.vtu",
                                "mixed_base64.vtu",     "mixed_base64_zlib.vtu",  "mixed_raw.vtu",
                                "mixed_appended64.vtu", "mixed_raw_zlib_big.vtu", "mixed_appended64_zlib.vtu"};

class MeshVariant : public testing::TestWithParam<const char*> {};

TEST_P(MeshVariant, GivesTheMixedBody) {
  const Model model = phymul::read_mesh(data(GetParam()), {.length_unit = 0.01});

  ASSERT_EQ(model.particle_count(), 12);
  EXPECT_EQ(model.rest[8], phymul::Vec3(1.5 * 0.01, 0.5 * 0.01, 0.0));
  EXPECT_EQ(model.rest[10], phymul::Vec3(0.5 * 0.01, 0.5 * 0.01, 1.7 * 0.01));
  const decltype(cell_set(model)) expected{{CellType::atom, {11}},
                                           {CellType::line, {10, 11}},
                                           {CellType::triangle, {1, 2, 8}},
                                           {CellType::quad, {0, 3, 2, 1}},
                                           {CellType::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}},
                                           {CellType::wedge, {1, 8, 2, 5, 9, 6}},
                                           {CellType::pyramid, {4, 5, 6, 7, 10}},
                                           {CellType::tetrahedron, {5, 6, 10, 11}}};
  EXPECT_EQ(cell_set(model), expected);
  EXPECT_EQ(model.cells.size(), expected.size());
  EXPECT_EQ(model.dimension, 3);
  EXPECT_EQ(model.mass, std::vector<double>(12, 1.0));
  const std::vector<Index> tip(model.neighbours.begin(11), model.neighbours.end(11));
  EXPECT_EQ(tip, (std::vector<Index>{5, 6, 10}));
}

INSTANTIATE_TEST_SUITE_P(AllFormats, MeshVariant, testing::ValuesIn(variants), [](const auto& variant) {
  std::string name = variant.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

class GmshVariant : public testing::TestWithParam<const char*> {};

TEST_P(GmshVariant, GivesPhysicalGroups) {
  const Model model = phymul::read_mesh(data(GetParam()));
  EXPECT_EQ(model.group("fixed side"), (std::vector<Index>{0, 1, 2, 3, 8}));
  EXPECT_EQ(model.group("tip"), (std::vector<Index>{11}));
  EXPECT_EQ(model.group("fibre"), (std::vector<Index>{10, 11}));
  EXPECT_EQ(model.group("tissue").size(), 12u);
  EXPECT_EQ(model.group("top"), (std::vector<Index>{4, 5, 6, 7, 10, 11}));
}

INSTANTIATE_TEST_SUITE_P(AllVersions, GmshVariant, testing::ValuesIn(variants, variants + 4), [](const auto& variant) {
  std::string name = variant.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(MeshRead, DropsUnusedPointsAndKeepsTheFilesNumbers) {
  const Model model = phymul::read_mesh(data("mixed_41.msh"));
  EXPECT_EQ(extras_of(model).particle_index, (std::vector<Index>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 21, 22}));
  ASSERT_FALSE(model.notes.empty());
  EXPECT_TRUE(says(model.notes.front(), "1 of 13 points are in no cell and were dropped (30)"));
}

TEST(MeshRead, NotesTheMassesAndStiffnessesAssumed) {
  const Model model = phymul::read_mesh(data("mixed_41.msh"), {.default_mass = 0.002});
  const std::string said = "no masses and no stiffness: 0.002 kg and 1 N/m a particle are assumed";
  EXPECT_TRUE(
      std::ranges::any_of(model.notes, [&](const std::string& note) { return note.find(said) != std::string::npos; }));
  EXPECT_EQ(model.mass.front(), 0.002);
}

TEST(MeshRead, NamesGroupsThatHaveNoName) {
  const std::string text = replaced(text_of(data("mixed_41.msh")), "3 5 \"top\"", "3 9 \"top\"");
  const Model model = read_text("unnamed.msh", text);
  EXPECT_EQ(model.group("volume 5").size(), 6u);
  EXPECT_FALSE(model.has_group("top"));
  EXPECT_TRUE(std::any_of(model.notes.begin(), model.notes.end(), [](const std::string& note) {
    return note.find("group \"top\" has no elements") != std::string::npos;
  }));
}

TEST(MeshRead, TurnsWronglyWoundCells) {
  const std::string text = replaced(text_of(data("mixed_41.msh")), "8 6 7 21 22", "8 7 6 21 22");
  const Model model = read_text("wound.msh", text);
  for (const phymul::Cell& cell : model.cells) {
    if (phymul::is_volume(cell.type)) {
      EXPECT_GT(phymul::cell_volume(model, cell), 0.0);
    }
  }
}

TEST(MeshRead, TakesVtkCellsWithOtherOrders) {
  const Model model =
      read_text("orders.vtk",
                "# vtk DataFile Version 3.0\nvoxel, pixel, polygon, wedge looking inward\nASCII\n"
                "DATASET UNSTRUCTURED_GRID\n"
                "FIELD FieldData 1\nTIME 1 2 double\n0.5 1\n"
                "POINTS 10 float\n0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1  2 0 0  2 0 1\n"
                "METADATA\nINFORMATION 0\n\n"
                "CELLS 4 25\n8 0 1 2 3 4 5 6 7\n4 0 1 2 3\n3 0 1 3\n6 1 8 3 5 9 7\n"
                "CELL_TYPES 4\n11\n8\n7\n13\nCELL_DATA 4\nanything\n");
  const decltype(cell_set(model)) expected{{CellType::hexahedron, {0, 1, 3, 2, 4, 5, 7, 6}},
                                           {CellType::quad, {0, 1, 3, 2}},
                                           {CellType::triangle, {0, 1, 3}},
                                           {CellType::wedge, {1, 8, 3, 5, 9, 7}}};
  EXPECT_EQ(cell_set(model), expected);
}

TEST(MeshRead, MakesPlaneFacesATwoDimensionalBody) {
  const Model model = read_text("plane.vtk",
                                "# vtk DataFile Version 3.0\nplane\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                "POINTS 4 float\n0 0 0 1 0 0 1 1 0 0 1 0\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n9\n");
  EXPECT_EQ(model.dimension, 2);
}

TEST(MeshRead, JoinsPiecesOfAVtu) {
  const std::string text = text_of(data("mixed_ascii.vtu"));
  const std::size_t begin = text.find("<Piece");
  const std::size_t end = text.find("</Piece>") + 8;
  const Model model = read_text("pieces.vtu", text.substr(0, end) + text.substr(begin, end - begin) + text.substr(end));
  EXPECT_EQ(model.particle_count(), 24);
  EXPECT_EQ(model.cells.size(), 16u);
  EXPECT_EQ(model.cells.back().particles.front(), model.cells[7].particles.front() + 12);
}

struct Refusal {
  const char* name;
  const char* file;  ///< of tests/data/mesh
  const char* from;  ///< text in it, replaced by `to`
  const char* to;
  std::vector<const char*> expected;  ///< parts of the message
};

const Refusal refusals[] = {
    {"SecondOrder",
     "mixed_41.msh",
     "3 2 4 1\n8 6 7 21 22",
     "3 2 11 1\n8 6 7 21 22 1 2 3 4 5 8",
     {".msh:67: ", "first-order", "type 11", "Mesh.ElementOrder = 1"}},
    {"UnknownNode", "mixed_41.msh", "8 6 7 21 22", "8 6 7 21 99", {".msh:68: ", "got 99 in element 8"}},
    {"NodeTwice", "mixed_41.msh", "30\n21\n", "21\n21\n", {".msh:45: ", "each node once", "21"}},
    {"NoNumber", "mixed_41.msh", "1.5 0.5 0\n", "1.5 0,5 0\n", {".msh:41: ", "\"0,5\"", "a coordinate"}},
    {"NotFinite", "mixed_41.msh", "1.5 0.5 0\n", "1.5 nan 0\n", {".msh:41: ", "finite", "NaN"}},
    {"HugeCount", "mixed_41.msh", "3 1 0 10\n", "3 1 0 1000000000000\n", {".msh:22: ", "1000000000000", "cut off"}},
    {"NegativeCount", "mixed_41.msh", "3 1 0 10\n", "3 1 0 -10\n", {".msh:22: ", "at least 0", "-10"}},
    {"TagTooLarge",
     "mixed_41.msh",
     "1.4 1 1.7 2 4 5",
     "1.4 1 1.7 2 4 -9223372036854775808",
     {".msh:18: ", "a physical tag of 32 bits", "-9223372036854775808"}},
    {"OldGmsh", "mixed_41.msh", "4.1 0 8", "4 0 8", {".msh:2: ", "4.1 or 2.2", "\"4\"", "-format msh41"}},
    {"WrongCount", "mixed_22.msh", "$Elements\n10", "$Elements\n9", {"$EndElements", "counts before it are wrong"}},
    {"NoElements", "mixed_22.msh", "$Elements", "$Other", {"$EndOther"}},
    {"NotGmsh", "mixed_22.msh", "$MeshFormat", "solid", {".msh:1: ", "expected $MeshFormat", "\"solid\""}},
    {"PointOutOfRange", "mixed_51.vtk", "\n11 10 11 1", "\n11 10 12 1", {".vtk:16: ", "0 to 12 - 1", "got 12"}},
    {"OffsetBackwards", "mixed_51.vtk", "0 1 3 6", "0 3 1 6", {".vtk:13: ", "offsets", "got 1"}},
    {"VtkSecondOrder", "mixed_42.vtk", "\n14", "\n24", {"cell 7", "type 24", "second or higher order", "linear"}},
    {"WrongCorners", "mixed_42.vtk", "\n14", "\n13", {"cell 7", "6 points", "got 5"}},
    {"TooFewTypes", "mixed_42.vtk", "CELL_TYPES 8", "CELL_TYPES 7", {".vtk:21: ", "got 7 types for 8 cells"}},
    {"Surface", "mixed_42.vtk", "UNSTRUCTURED_GRID", "POLYDATA", {".vtk:4: ", "UNSTRUCTURED_GRID", "polydata"}},
    {"Compressor", "mixed_base64_zlib.vtu", "vtkZLib", "vtkLZ4", {".vtu:2: ", "vtkZLibDataCompressor", "vtkLZ4Data"}},
    {"NotBase64", "mixed_base64.vtu", "AAAA", "A*AA", {"array \"Points\"", "base64", "\"*\""}},
    {"MorePoints",
     "mixed_base64.vtu",
     "NumberOfPoints=\"12\"",
     "NumberOfPoints=\"13\"",
     {"array \"Points\"", "expected 312 bytes", "got 288"}},
    {"ManyPoints", "mixed_ascii.vtu", "NumberOfPoints=\"12\"", "NumberOfPoints=\"99999999\"", {"cut off"}},
    {"WrongOffset", "mixed_raw.vtu", "offset=\"0\"", "offset=\"9999\"", {".vtu:", "offset below"}},
    {"NoCount",
     "mixed_raw.vtu",
     "NumberOfCells=\"8\"",
     "NumberOfCells=\"-8\"",
     {".vtu:3: ", "NumberOfCells", "\"-8\""}},
    {"BrokenXml", "mixed_ascii.vtu", "</Cells>", "</Cell>", {".vtu:", "well-formed XML"}},
    {"PolyData", "mixed_ascii.vtu", "type=\"UnstructuredGrid\"", "type=\"PolyData\"", {".vtu:2: ", "\"PolyData\""}},
};

class MeshRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(MeshRefusal, SaysWhereAndWhat) {
  const Refusal& refusal = GetParam();
  const std::string message = message_of(std::string("refused_") + refusal.file,
                                         replaced(text_of(data(refusal.file)), refusal.from, refusal.to));
  for (const char* part : refusal.expected) EXPECT_TRUE(says(message, part)) << part << " in: " << message;
}

INSTANTIATE_TEST_SUITE_P(Faults, MeshRefusal, testing::ValuesIn(refusals),
                         [](const auto& variant) { return std::string(variant.param.name); });

TEST(MeshRead, SaysTheByteInBinaryFiles) {
  const std::string text = text_of(data("mixed_41_binary.msh"));
  const std::string message = message_of("short.msh", text.substr(0, text.find("$EndNodes") - 20));
  EXPECT_TRUE(says(message, ".msh: byte "));
  EXPECT_TRUE(says(message, "cut off"));
}

TEST(MeshRead, RefusesFilesWithoutCells) {
  EXPECT_TRUE(refuses("points.vtk",
                      "# vtk DataFile Version 3.0\npoints\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                      "POINTS 1 float\n0 0 0\nCELLS 1 2\n1 0\nCELL_TYPES 1\n1\n",
                      "expected cells"));
}

TEST(MeshRead, RefusesWhatIsNoMesh) {
  EXPECT_TRUE(refuses("empty.msh", "", "got an empty file"));
  EXPECT_TRUE(refuses("body.pml", "<physicalModel/>", "read_pml"));
  EXPECT_THROW(phymul::read_mesh(data("no_such_file.msh")), phymul::Error);
  EXPECT_THROW(phymul::read_mesh(PHYMUL_TEST_DATA), phymul::Error);
  EXPECT_THROW(phymul::read_mesh(data("mixed_41.msh"), {.max_bytes = 100}), phymul::Error);
  EXPECT_THROW(phymul::read_mesh(data("mixed_41.msh"), {.length_unit = 0.0}), phymul::Error);
}

/// Every beginning of every file is refused or, where only white space is missing, read.
TEST(MeshRead, SurvivesTruncation) {
  for (const char* variant : variants) {
    const std::string text = text_of(data(variant));
    int refused = 0;
    for (std::size_t length = 0; length < text.size(); length += 1 + text.size() / 64) {
      refused += message_of(variant, text.substr(0, length)) != "loaded";
    }
    EXPECT_GE(refused, 32) << variant;
  }
}

TEST(MeshRead, SurvivesMutation) {
  std::mt19937 random(20250101);
  int refused = 0;
  int loaded = 0;
  for (const char* variant : variants) {
    const std::string text = text_of(data(variant));
    for (int trial = 0; trial < 300; ++trial) {
      std::string mutated = text;
      for (std::uint32_t k = 0; k < 1 + random() % 4; ++k) {
        const std::size_t place = random() % mutated.size();
        switch (random() % 4) {
          case 0:
            mutated[place] = static_cast<char>(random());
            break;
          case 1:
            mutated[place] = "0123456789-.e<>\" "[random() % 17];
            break;
          case 2:
            mutated.erase(place, 1 + random() % 20);
            break;
          default: {
            const auto length = random() % 20, from = random() % mutated.size();
            mutated.insert(place, mutated.substr(from, length));
          }
        }
        if (mutated.empty()) mutated = "$";
      }
      (message_of(variant, mutated) == "loaded" ? loaded : refused) += 1;
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(loaded, 20);
}

}  // namespace
