// SPDX-License-Identifier: MIT
//
// Corners of the mesh formats that the sample files do not reach.
#include <gtest/gtest.h>
#include <phymul/error.h>
#include <phymul/mesh.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

#include "base/byte_source.h"
#include "io/mesh/mesh_parts.h"
#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul {
namespace {

std::string sample(const std::string& name) {
  return text_of(PHYMUL_TEST_DATA "/mesh/" + name);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

/// Reads a sample with one text in it replaced.
Model changed(const std::string& name, const std::string& from, const std::string& to) {
  return mesh_from_bytes(name, replaced(sample(name), from, to), {});
}

void expect_refused(const std::string& name, const std::string& text, const std::string& part) {
  const std::string message = message_of([&] { mesh_from_bytes(name, text, {}); });
  EXPECT_TRUE(says(message, part)) << part << " in: " << message;
}

void expect_refused(const std::string& name, const std::string& from, const std::string& to, const std::string& part) {
  expect_refused(name, replaced(sample(name), from, to), part);
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
    const Model model = mesh_from_bytes("t.msh", binary_gmsh_2(swap), {});
    ASSERT_EQ(model.cells.size(), 1u);
    EXPECT_EQ(model.rest[3], Vec3(0, 0, 1));
    EXPECT_EQ(cell_volume(model, model.cells[0]), 1.0 / 6.0);
    expect_refused("t.msh", binary_gmsh_2(swap, 2), "add up to $Elements' count");
  }
}

TEST(MeshFormat, GmshParametricNodes) {
  const Model model = mesh_from_bytes("t.msh",
                                      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n2 1 1 4\n1\n2\n3\n4\n"
                                      "0 0 0 0.5 0.5\n1 0 0 0.5 0.5\n0 1 0 0.5 0.5\n0 0 1 0.5 0.5\n$EndNodes\n"
                                      "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n",
                                      {});
  EXPECT_EQ(model.rest[3], Vec3(0, 0, 1));
}

TEST(MeshFormat, GmshGroupsOfReversedOrPartitionedEntities) {
  EXPECT_EQ(changed("mixed_41.msh", "1.4 1 1.7 2 4 5", "1.4 1 1.7 2 -4 5").group("tissue").size(), 12u);
  const Model model = changed("mixed_41.msh", "$Nodes", "$PartitionedEntities\n1\n$EndPartitionedEntities\n$Nodes");
  EXPECT_TRUE(std::any_of(model.notes.begin(), model.notes.end(), [](const std::string& note) {
    return note.find("the mesh is partitioned") != std::string::npos;
  }));
}

TEST(MeshFormat, GmshRefusals) {
  expect_refused("mixed_22.msh", "$Elements", "$Nodes\n0\n$EndNodes\n$Elements", "expected one section $Nodes");
  expect_refused("mixed_41.msh", "4.1 0 8", "4.1 0 4", "expected a data size of 8 bytes, got 4");
  expect_refused("mixed_41.msh", "3 2 4 1\n8 6", "3 2 11 1\n8 6", "type 11, of second or higher order");
  expect_refused("mixed_41.msh", "3 2 4 1\n8 6", "3 2 200 1\n8 6", "got type 200; export");
}

TEST(MeshFormat, VtkRefusals) {
  const std::string text = sample("mixed_42.vtk");
  expect_refused("t.vtk", replaced(text, "CELLS 8", "POINTS 0 double\n\nCELLS 8"), "expected POINTS once");
  expect_refused("t.vtk", replaced(text, "CELL_TYPES", "CELLS 0 0\nCELL_TYPES"), "expected CELLS once");
  expect_refused("t.vtk", replaced(text, "CELLS 8 41", "CELLS 8 42"), "expected cells of 42 numbers in all, got 41");
  expect_refused("t.vtk", text.substr(0, text.find("CELL_TYPES")), "expected CELL_TYPES");
  expect_refused("mixed_51.vtk", "\n0 1 3 6", "\n1 1 3 6", "expected offsets that grow from 0");
}

TEST(MeshFormat, VtkFieldsWithMetadataBetween) {
  EXPECT_EQ(changed("mixed_42.vtk", "POINTS",
                    "FIELD FieldData 2\nA 1 1 double\n0.5\nMETADATA\nINFORMATION 0\n\nB 1 1 double\n1\nPOINTS")
                .particle_count(),
            12);
}

TEST(MeshFormat, NumbersTooSmallForADoubleAreZero) {
  EXPECT_EQ(changed("mixed_42.vtk", "1.5 0.5 1 0.5", "1.5 0.5 1e-400 0.5").rest[9].z(), 0.0);
}

TEST(MeshFormat, OnlyFlatFacesMakeATwoDimensionalBody) {
  const std::string head = "# vtk DataFile Version 3.0\nshell\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n";
  const std::string tail = "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n";
  EXPECT_EQ(mesh_from_bytes("t.vtk", head + "0 0 0 1 0 0 1 1 0\n" + tail, {}).dimension, 2);
  EXPECT_EQ(mesh_from_bytes("t.vtk", head + "0 0 0 1 0 0 1 1 1\n" + tail, {}).dimension, 3);
}

TEST(MeshFormat, VtuPieces) {
  const std::string text = replaced(sample("mixed_ascii.vtu"), "<PointData>",
                                    "<PointData><DataArray type=\"Int8\" Name=\"group:half\" format=\"ascii\">"
                                    "0 0 0 0 0 0 0 0 0 0 1 1</DataArray>");
  const std::size_t begin = text.find("<Piece");
  const std::size_t end = text.find("</Piece>") + 8;
  const std::string empty = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"></Piece>";
  const Model model = mesh_from_bytes(
      "t.vtu", text.substr(0, begin) + empty + text.substr(begin, end - begin) + text.substr(begin), {});
  EXPECT_EQ(model.particle_count(), 24);
  EXPECT_EQ(model.group("half"), (std::vector<Index>{10, 11, 22, 23}));
}

TEST(MeshFormat, VtuRefusals) {
  expect_refused("mixed_ascii.vtu", "1 3 6 10 18", "3 1 6 10 18", "expected offsets that grow, got 1");
  expect_refused("mixed_ascii.vtu", "Components=\"3\"", "Components=\"2\"", "expected 3 components in \"Points\"");
  std::string text = sample("mixed_base64.vtu");
  const std::size_t data = text.find_first_not_of(" \n", text.find('>', text.find("Name=\"Points\"")) + 1);
  text[data + 2] = '=';  // padding is for the end of a group of four
  text[data + 3] = 'A';
  expect_refused("t.vtu", text, "expected base64 characters, got \"A\"");
}

TEST(MeshFormat, VtuLinesCountTheAppendedDataToo) {
  const std::string text = replaced(sample("mixed_raw.vtu"), "</VTKFile>", "</VTK>");
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find("</VTK>")), '\n');
  expect_refused("t.vtu", text, "t.vtu:" + std::to_string(line) + ": expected well-formed XML");
}

TEST(MeshFormat, CountsBeyond63BitsAreDamage) {
  const std::string bytes(8, '\xff');
  ByteSource source = ByteSource::decoded("here", bytes, false);
  EXPECT_TRUE(refuses([&] { source.integer(NumberType::uint64, "a count"); }, "18446744073709551615; the file"));
}

TEST(MeshFormat, AFolderIsNoMesh) {
  EXPECT_TRUE(refuses([] { read_mesh(PHYMUL_TEST_DATA); }, "expected a file, got a folder"));
}

}  // namespace
}  // namespace phymul
