// SPDX-License-Identifier: MIT
//
// tests/data/mesh holds one mesh of every cell type, in files that Gmsh 4.8 and VTK 9.1 wrote from mixed_41.msh. After
// these come corners of the formats that they do not reach; damaged files are the subject of altered_meshes_test.cpp.
#include <gtest/gtest.h>
#include <phymul/mesh.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "base/byte_source.h"
#include "io/mesh/mesh_parts.h"
#include "model/file_extras.h"
#include "support/pml_text.h"
#include "support/text_file.h"

namespace phymul {
namespace {

std::string data(const std::string& name) {
  return PHYMUL_TEST_DATA "/mesh/" + name;
}

Model read_text(const std::string& name, const std::string& text) {
  return mesh_from_bytes(name, text, {});
}

/// A sample's text with one part of it replaced, and what is read from that.
std::string altered(const std::string& name, const std::string& from, const std::string& to) {
  return replaced(text_of(data(name)), from, to);
}
Model changed(const std::string& name, const std::string& from, const std::string& to) {
  return read_text(name, altered(name, from, to));
}

void expect_refused(const std::string& name, const std::string& text, const std::string& part) {
  EXPECT_TRUE(refuses([&] { read_text(name, text); }, part));
}

std::set<std::pair<CellType, std::vector<Index>>> cell_set(const Model& model) {
  std::set<std::pair<CellType, std::vector<Index>>> cells;
  for (const Cell& cell : model.cells) cells.emplace(cell.type, cell.particles);
  return cells;
}

const char* const variants[] = {"mixed_41.msh",         "mixed_41_binary.msh",    "mixed_22.msh",
                                "mixed_22_binary.msh",  "mixed_42.vtk",           "mixed_42_binary.vtk",
                                "mixed_51.vtk",         "mixed_51_binary.vtk",    "mixed_ascii.vtu",
                                "mixed_base64.vtu",     "mixed_base64_zlib.vtu",  "mixed_raw.vtu",
                                "mixed_appended64.vtu", "mixed_raw_zlib_big.vtu", "mixed_appended64_zlib.vtu"};

class MeshVariant : public testing::TestWithParam<const char*> {};

TEST_P(MeshVariant, GivesTheMixedBody) {
  const Model model = read_mesh(data(GetParam()), {.length_unit = 0.01});

  ASSERT_EQ(model.particle_count(), 12);
  EXPECT_EQ(model.rest[8], Vec3(1.5 * 0.01, 0.5 * 0.01, 0.0));
  EXPECT_EQ(model.rest[10], Vec3(0.5 * 0.01, 0.5 * 0.01, 1.7 * 0.01));
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

std::string test_name(const testing::TestParamInfo<const char*>& variant) {
  std::string name = variant.param;
  std::ranges::replace(name, '.', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(AllFormats, MeshVariant, testing::ValuesIn(variants), test_name);

class GmshVariant : public testing::TestWithParam<const char*> {};

TEST_P(GmshVariant, GivesPhysicalGroups) {
  const Model model = read_mesh(data(GetParam()));
  EXPECT_EQ(model.group("fixed side"), (std::vector<Index>{0, 1, 2, 3, 8}));
  EXPECT_EQ(model.group("tip"), (std::vector<Index>{11}));
  EXPECT_EQ(model.group("fibre"), (std::vector<Index>{10, 11}));
  EXPECT_EQ(model.group("tissue").size(), 12u);
  EXPECT_EQ(model.group("top"), (std::vector<Index>{4, 5, 6, 7, 10, 11}));
}

INSTANTIATE_TEST_SUITE_P(AllVersions, GmshVariant, testing::ValuesIn(variants, variants + 4), test_name);

TEST(MeshRead, DropsUnusedPointsAndKeepsTheFilesNumbers) {
  const Model model = read_mesh(data("mixed_41.msh"));
  EXPECT_EQ(extras_of(model).particle_index, (std::vector<Index>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 21, 22}));
  ASSERT_FALSE(model.notes.empty());
  EXPECT_TRUE(says(model.notes.front(), "1 of 13 points are in no cell and were dropped (30)"));
}

TEST(MeshRead, NotesTheMassesAndStiffnessesAssumed) {
  const Model model = read_mesh(data("mixed_41.msh"), {.default_mass = 0.002});
  EXPECT_TRUE(has_note(model.notes, "no masses and no stiffness: 0.002 kg and 1 N/m a particle are assumed"));
  EXPECT_EQ(model.mass.front(), 0.002);
}

TEST(MeshRead, NamesGroupsThatHaveNoName) {
  const Model model = changed("mixed_41.msh", "3 5 \"top\"", "3 9 \"top\"");
  EXPECT_EQ(model.group("volume 5").size(), 6u);
  EXPECT_FALSE(model.has_group("top"));
  EXPECT_TRUE(has_note(model.notes, "group \"top\" has no elements"));
}

TEST(MeshRead, TurnsWronglyWoundCells) {
  const Model model = changed("mixed_41.msh", "8 6 7 21 22", "8 7 6 21 22");
  for (const Cell& cell : model.cells) {
    if (is_volume(cell.type)) {
      EXPECT_GT(cell_volume(model, cell), 0.0);
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

struct Refusal {
  const char* name;
  const char* file;  ///< of tests/data/mesh
  const char* from;  ///< text in it, replaced by `to`
  const char* to;
  std::vector<const char*> expected;  ///< parts of the message

  friend void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.file; }
};

const Refusal refusals[] = {
    {"ThirdOrder",
     "mixed_41.msh",
     "3 2 4 1\n8",
     "3 2 29 1\n8",
     {".msh:67: ", "type 29, of higher", "ElementOrder = 1"}},
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
    {"VtkPolyhedron", "mixed_42.vtk", "\n14", "\n42", {"cell 7", "type 42", "export tetrahedra"}},
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
    {"NodesTwice", "mixed_22.msh", "$Elements", "$Nodes\n0\n$EndNodes\n$Elements", {"expected one section $Nodes"}},
    {"DataSize", "mixed_41.msh", "4.1 0 8", "4.1 0 4", {"expected a data size of 8 bytes, got 4"}},
    {"UnknownType", "mixed_41.msh", "3 2 4 1\n8 6", "3 2 200 1\n8 6", {"got type 200; export"}},
    {"PointsTwice", "mixed_42.vtk", "CELLS 8", "POINTS 0 double\n\nCELLS 8", {"expected POINTS once"}},
    {"CellsTwice", "mixed_42.vtk", "CELL_TYPES", "CELLS 0 0\nCELL_TYPES", {"expected CELLS once"}},
    {"CellNumbers", "mixed_42.vtk", "CELLS 8 41", "CELLS 8 42", {"expected cells of 42 numbers in all, got 41"}},
    {"OffsetsFromOne", "mixed_51.vtk", "\n0 1 3 6", "\n1 1 3 6", {"expected offsets that grow from 0"}},
    {"PieceOffsets", "mixed_ascii.vtu", "1 3 6 10 18", "3 1 6 10 18", {"expected offsets that grow, got 1"}},
    {"Components", "mixed_ascii.vtu", "Components=\"3\"", "Components=\"2\"", {"expected 3 components in \"Points\""}},
};

class MeshRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(MeshRefusal, SaysWhereAndWhat) {
  const Refusal& refusal = GetParam();
  const std::string name = std::string("refused_") + refusal.file;
  const std::string text = altered(refusal.file, refusal.from, refusal.to);
  for (const char* part : refusal.expected) expect_refused(name, text, part);
}

INSTANTIATE_TEST_SUITE_P(Faults, MeshRefusal, testing::ValuesIn(refusals),
                         [](const auto& variant) { return std::string(variant.param.name); });

TEST(MeshRead, SaysTheByteInBinaryFiles) {
  const std::string text = text_of(data("mixed_41_binary.msh"));
  EXPECT_TRUE(
      refuses([&] { read_text("short.msh", text.substr(0, text.find("$EndNodes") - 20)); }, ".msh: byte ", "cut off"));
}

TEST(MeshRead, RefusesWhatIsNoMesh) {
  expect_refused("empty.msh", "", "got an empty file");
  expect_refused("body.pml", "<physicalModel/>", "read_pml");
  expect_refused("points.vtk",
                 "# vtk DataFile Version 3.0\npoints\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                 "POINTS 1 float\n0 0 0\nCELLS 1 2\n1 0\nCELL_TYPES 1\n1\n",
                 "expected cells");
  const std::string text = text_of(data("mixed_42.vtk"));
  expect_refused("t.vtk", text.substr(0, text.find("CELL_TYPES")), "expected CELL_TYPES");
  EXPECT_TRUE(refuses([] { read_mesh(PHYMUL_TEST_DATA); }, "expected a file, got a folder"));
  EXPECT_THROW(read_mesh(data("no_such_file.msh")), Error);
  EXPECT_THROW(read_mesh(data("mixed_41.msh"), {.max_bytes = 100}), Error);
  EXPECT_THROW(read_mesh(data("mixed_41.msh"), {.length_unit = 0.0}), Error);
}

/// Bytes of a number, the other way round where `swap`.
template <class T>
std::string raw(T value, bool swap) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// A binary file of version 2.2 with one tetrahedron, its block of elements said to hold `block`.
std::string binary_gmsh_2(bool swap, std::int32_t block = 1) {
  std::string text = "$MeshFormat\n2.2 1 8\n" + raw<std::int32_t>(1, swap) + "\n$EndMeshFormat\n$Nodes\n4\n";
  for (std::int32_t i = 0; i < 4; ++i) {
    text += raw(i + 1, swap);
    for (std::int32_t axis = 0; axis < 3; ++axis) text += raw(i == axis + 1 ? 1.0 : 0.0, swap);
  }
  text += "\n$EndNodes\n$Elements\n1\n";
  for (const std::int32_t number : {4, block, 2, 1, 7, 7, 1, 2, 3, 4}) text += raw(number, swap);
  return text + "\n$EndElements\n";
}

TEST(MeshFormat, GmshBinaryOfEitherByteOrder) {
  for (const bool swap : {false, true}) {
    const Model model = read_text("t.msh", binary_gmsh_2(swap));
    ASSERT_EQ(model.cells.size(), 1u);
    EXPECT_EQ(model.rest[3], Vec3(0, 0, 1));
    EXPECT_EQ(cell_volume(model, model.cells[0]), 1.0 / 6.0);
    expect_refused("t.msh", binary_gmsh_2(swap, 2), "add up to $Elements' count");
  }
}

TEST(MeshFormat, GmshParametricNodes) {
  const Model model = read_text("t.msh",
                                "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n2 1 1 4\n1\n2\n3\n4\n"
                                "0 0 0 0.5 0.5\n1 0 0 0.5 0.5\n0 1 0 0.5 0.5\n0 0 1 0.5 0.5\n$EndNodes\n"
                                "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n");
  EXPECT_EQ(model.rest[3], Vec3(0, 0, 1));
}

TEST(MeshFormat, GmshGroupsOfReversedOrPartitionedEntities) {
  EXPECT_EQ(changed("mixed_41.msh", "1.4 1 1.7 2 4 5", "1.4 1 1.7 2 -4 5").group("tissue").size(), 12u);
  const Model model = changed("mixed_41.msh", "$Nodes", "$PartitionedEntities\n1\n$EndPartitionedEntities\n$Nodes");
  EXPECT_TRUE(has_note(model.notes, "the mesh is partitioned"));
}

TEST(MeshFormat, VtkFieldsWithMetadataBetween) {
  EXPECT_EQ(changed("mixed_42.vtk", "POINTS",
                    "FIELD FieldData 2\nA 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nB 1 1 double\n1\nPOINTS")
                .particle_count(),
            12);
}

TEST(MeshFormat, NumbersTooSmallForADoubleAreZero) {
  for (const std::string tiny : {"1e-400", "-1E-400"}) {
    EXPECT_EQ(changed("mixed_42.vtk", "1.5 0.5 1 0.5", "1.5 0.5 " + tiny + " 0.5").rest[9].z(), 0.0) << tiny;
  }
}

TEST(MeshFormat, OnlyFlatFacesMakeATwoDimensionalBody) {
  const std::string head = "# vtk DataFile Version 3.0\nshell\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n";
  const std::string tail = "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n";
  EXPECT_EQ(read_text("t.vtk", head + "0 0 0 1 0 0 1 1 0\n" + tail).dimension, 2);
  EXPECT_EQ(read_text("t.vtk", head + "0 0 0 1 0 0 1 1 1\n" + tail).dimension, 3);
}

TEST(MeshFormat, VtuPieces) {
  const std::string text = altered("mixed_ascii.vtu", "<PointData>",
                                   "<PointData><DataArray type=\"Int8\" Name=\"group:half\" format=\"ascii\">"
                                   "0 0 0 0 0 0 0 0 0 0 1 1</DataArray>");
  const std::size_t begin = text.find("<Piece");
  const std::size_t end = text.find("</Piece>") + 8;
  const std::string empty = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"></Piece>";
  const Model model =
      read_text("t.vtu", text.substr(0, begin) + empty + text.substr(begin, end - begin) + text.substr(begin));
  EXPECT_EQ(model.particle_count(), 24);
  EXPECT_EQ(model.cells.back().particles.front(), model.cells[7].particles.front() + 12);
  EXPECT_EQ(model.group("half"), (std::vector<Index>{10, 11, 22, 23}));
}

TEST(MeshFormat, VtuPaddingIsForTheEndOfAGroup) {
  std::string text = text_of(data("mixed_base64.vtu"));
  const std::size_t data = text.find_first_not_of(" \n", text.find('>', text.find("Name=\"Points\"")) + 1);
  text[data + 2] = '=';
  text[data + 3] = 'A';
  expect_refused("t.vtu", text, "expected base64 characters, got \"A\"");
}

TEST(MeshFormat, VtuLinesCountTheAppendedDataToo) {
  const std::string text = altered("mixed_raw.vtu", "</VTKFile>", "</VTK>");
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find("</VTK>")), '\n');
  expect_refused("t.vtu", text, "t.vtu:" + std::to_string(line) + ": expected well-formed XML");
}

TEST(MeshFormat, CountsBeyond63BitsAreDamage) {
  const std::string bytes(8, '\xff');
  ByteSource source = ByteSource::decoded("here", bytes, false);
  EXPECT_TRUE(refuses([&] { source.integer(NumberType::uint64, "a count"); }, "18446744073709551615; the file"));
}

}  // namespace
}  // namespace phymul
