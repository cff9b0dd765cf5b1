// SPDX-License-Identifier: MIT
//
// Groups of meshes and their names, files made to take much memory, and options that are refused.
#include <phymul/phymul.h>

#include <gtest/gtest.h>
#include <new>
#include <numeric>
#include <sstream>

#include "io/mesh/mesh_parts.h"
#include "support/allocation_count.h"
#include "support/message_of.h"
#include "support/pml_text.h"

namespace phymul::test {
namespace {

const std::string gmsh_2_head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";

/// Two tetrahedra; the first is in a physical group of this name.
std::string gmsh_2(const std::string& name) {
  return gmsh_2_head + "$PhysicalNames\n1\n3 1 \"" + name +
         "\"\n$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n"
         "$Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 2 1 2 3 4 5\n$EndElements\n";
}

Model read_gmsh_text(const std::string& text) {
  return mesh_from_bytes("t.msh", text, {});
}

/// A tetrahedron, many times, of an entity in physical groups with these tags.
std::string gmsh_4(int elements, const std::vector<int>& tags) {
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 ";
  text += std::to_string(tags.size());
  for (const int tag : tags) text += ' ' + std::to_string(tag);
  text += " 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n";
  const std::string count = std::to_string(elements);
  text += "$Elements\n1 " + count + " 1 9\n3 1 4 " + count + '\n';
  for (int k = 0; k < elements; ++k) text += "1 1 2 3 4\n";
  return text + "$EndElements\n";
}

TEST(MeshGroups, ATagThatIsRepeatedIsOneGroup) {
  const MeshParts parts = read_gmsh("t.msh", gmsh_4(20, std::vector<int>(50, 7)));
  ASSERT_EQ(parts.groups.size(), 1u);
  EXPECT_EQ(parts.groups[0].cells.size(), 20u);
}

TEST(MeshGroups, FarMoreMembershipsThanBytesAreDamage) {
  std::vector<int> tags(200);
  for (std::size_t k = 0; k < tags.size(); ++k) tags[k] = static_cast<int>(k) + 1;
  EXPECT_EQ(read_gmsh("t.msh", gmsh_4(3, tags)).groups.size(), tags.size());
  EXPECT_EQ(read_gmsh("t.msh", gmsh_4(200, tags)).groups.back().cells.size(), 200u);
  for (int k = 0; k < 1000; ++k) tags.push_back(static_cast<int>(tags.size()) + 1);
  EXPECT_TRUE(refuses([&] { read_gmsh("t.msh", gmsh_4(200, tags)); }, "16 physical groups for each byte of the file"));
}

/// Pieces of one tetrahedron with the same appended bytes.
std::string vtu_of_pieces(int count) {
  std::string raw, xml = "<VTKFile type='UnstructuredGrid' header_type='UInt64'><UnstructuredGrid>";
  const auto put = [&raw](const auto& numbers) {
    const std::uint64_t bytes = sizeof numbers;
    raw.append(reinterpret_cast<const char*>(&bytes), 8).append(reinterpret_cast<const char*>(&numbers), bytes);
  };
  const double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::int32_t offset[1] = {4}, connectivity[4] = {0, 1, 2, 3};
  const std::uint8_t type[1] = {10};
  put(points);
  const std::size_t at_offset = raw.size();
  put(offset);
  const std::size_t at_connectivity = raw.size();
  put(connectivity);
  const std::size_t at_type = raw.size();
  put(type);
  const auto array = [](const char* of, const char* name, int components, std::size_t at) {
    return std::string("<DataArray type='") + of + "' Name='" + name + "' NumberOfComponents='" +
           std::to_string(components) + "' format='appended' offset='" + std::to_string(at) + "'/>";
  };
  for (int k = 0; k < count; ++k) {
    xml += "<Piece NumberOfPoints='4' NumberOfCells='1'><Points>" + array("Float64", "Points", 3, 0) +
           "</Points><Cells>" + array("Int32", "connectivity", 1, at_connectivity) +
           array("Int32", "offsets", 1, at_offset) + array("UInt8", "types", 1, at_type) + "</Cells></Piece>";
  }
  return xml + "</UnstructuredGrid><AppendedData encoding='raw'>_" + raw + "</AppendedData></VTKFile>";
}

TEST(MeshGroups, AppendedArraysOfAVtuFileDoNotOverlap) {
  EXPECT_EQ(read_vtu("t.vtu", vtu_of_pieces(1)).cells.size(), 1u);
  EXPECT_TRUE(refuses([&] { read_vtu("t.vtu", vtu_of_pieces(3)); }, "t.vtu:1: expected appended arrays that lie"));
}

TEST(MeshGroups, APieceOfAVtuFileWithoutPointsHasNoCells) {
  const std::string text = replaced(vtu_of_pieces(1), "NumberOfPoints='4'", "NumberOfPoints='0'");
  EXPECT_TRUE(refuses([&] { read_vtu("t.vtu", text); }, "expected no cells in a piece without points, got 1"));
}

TEST(MeshGroups, NamesInLatin1BecomeUtf8) {
  const Model model =
      read_gmsh_text(gmsh_2("m\xE2"
                            "choire"));
  EXPECT_EQ(model
                .group("m\xC3\xA2"
                       "choire")
                .size(),
            4u);
  EXPECT_EQ(reread(model), model);
}

TEST(MeshGroups, OneCalledElementsStaysItself) {
  const Model model = read_gmsh_text(gmsh_2("Elements"));
  EXPECT_EQ(model.group("Elements").size(), 4u);
  EXPECT_EQ(model.group("Elements 2").size(), 5u);
  EXPECT_TRUE(has_note(model.notes, "the component of all cells is called \"Elements 2\""));
  EXPECT_EQ(read_gmsh_text(gmsh_2("half")).group("Elements").size(), 5u);
}

TEST(MeshGroups, ByteOrderMarksAndBlankLinesMayComeFirst) {
  for (const std::string start : {"\xEF\xBB\xBF", "\n \t", "\xEF\xBB\xBF\n\n"}) {
    EXPECT_EQ(read_gmsh_text(start + gmsh_2("half")).particle_count(), 5);
    const Model model = mesh_from_bytes("t.vtk",
                                        start +
                                            "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                            "POINTS 3 double\n0 0 0 1 0 0 0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n",
                                        {});
    EXPECT_EQ(model.particle_count(), 3);
  }
}

TEST(MeshGroups, OptionsThatNoModelMayHaveAreRefusedAsSuch) {
  const std::string text = gmsh_2("half");
  const auto message = [&](const MeshOptions& options) {
    return message_of([&] { mesh_from_bytes("t.msh", text, options); });
  };
  EXPECT_EQ(message({.default_mass = 0.0}), "read_mesh: expected a default_mass above 0 kg, got 0");
  EXPECT_EQ(message({.default_stiffness = -1.0}), "read_mesh: expected a default_stiffness of 0 N/m or more, got -1");
  EXPECT_EQ(message({.length_unit = 0.0}), "read_mesh: expected a length_unit above 0 (metres per file unit), got 0");
}

TEST(MeshGroups, AFileWithoutRoomInMemoryIsSaid) {
  const std::string source = "t.msh", text = gmsh_2("half");
  int failed = 0;
  for (std::size_t k = 1; k <= 60; ++k) {
    try {
      const FailingAllocation failing(k);
      mesh_from_bytes(source, text, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::out_of_memory) << error.what();
      ++failed;
    } catch (const std::bad_alloc&) {
      ADD_FAILURE() << "allocation " << k;
    }
  }
  EXPECT_GT(failed, 30);
}

// Meshes whose cells are not all volumes of first order, and Gmsh's first format.

using VtkCell = std::pair<int, std::vector<int>>;  // type and points

/// Of 30 points on no common plane.
Model read_vtk(const std::vector<VtkCell>& cells) {
  std::ostringstream text, rows, types;
  std::size_t numbers = cells.size();
  text << "# vtk DataFile Version 3.0\nkinds\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 30 double\n";
  for (int i = 0; i < 30; ++i) text << (i == 1) + 0.1 * i << ' ' << (i == 2) + 0.01 * i * i << ' ' << i % 4 << '\n';
  for (const auto& [type, points] : cells) {
    numbers += points.size();
    rows << points.size();
    for (const int p : points) rows << ' ' << p;
    rows << '\n';
    types << type << '\n';
  }
  text << "CELLS " << cells.size() << ' ' << numbers << '\n' << rows.str() << "CELL_TYPES " << cells.size() << '\n';
  return mesh_from_bytes("t.vtk", text.str() + types.str(), {});
}

TEST(MeshKinds, WhatIsNoVolumeIsLeftOutWithANote) {
  const VtkCell body{10, {0, 1, 2, 3}}, skin{5, {0, 1, 2}}, polygon{7, {0, 1, 4, 5, 6}};
  const std::vector<VtkCell> strays{
      polygon,        {36, {4, 5, 6, 7, 8, 9}}, {6, {0, 1, 4, 5}}, {3, {3, 5}}, {21, {3, 5, 6}},
      {4, {5, 6, 7}}, {5, {5, 6, 7}},           {9, {5, 6, 7, 8}}, {1, {9}},    {2, {8, 9}}};
  const char* const kinds[] = {"polygon",   "polygon",  "triangle strip", "line", "line",
                               "poly_line", "triangle", "quad",           "atom", "poly_vertex"};
  for (std::size_t k = 0; k < strays.size(); ++k) {
    Model model = read_vtk({body, skin, strays[k]});
    EXPECT_EQ(model.particle_count(), 4);
    EXPECT_EQ(model.cells.size(), 2u);  // the face of a volume stays
    EXPECT_TRUE(has_note(model.notes, std::string("not part of one were left out (1 ") + kinds[k] + ")")) << kinds[k];
    set_material(model, {.young = 1e4, .poisson = 0.3, .density = 1000.0});
  }
  EXPECT_TRUE(refuses([&] { read_vtk({skin, polygon}); }, "faces of 3 or 4 corners, or lines), got 1 polygon"));
}

TEST(MeshKinds, AFlatSheetBecomesAWallInThreeDimensions) {
  Model sheet = mesh_from_bytes("t.vtk",
                                "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 double\n"
                                "0 0 0 1 0 0 0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n",
                                {});
  const Material wall{.young = 1e4, .poisson = 0.3, .density = 1000.0, .thickness = 1e-3};
  EXPECT_TRUE(refuses([&] { set_material(sheet, wall); }, "got one in 2; set Model::dimension to 3 ("));
  sheet.dimension = 3;
  set_material(sheet, wall);
  EXPECT_TRUE(has_walls(sheet));
}

TEST(MeshKinds, OfSecondOrderCellsTheCornersAreTaken) {
  using enum CellType;
  const CellType types[] = {tetrahedron, hexahedron, wedge, pyramid, hexahedron, wedge, wedge, hexahedron, pyramid};
  const int numbers[] = {24, 25, 26, 27, 29, 31, 32, 33, 37}, points[] = {10, 20, 15, 13, 27, 12, 18, 24, 19};
  for (int k = 0; k < 9; ++k) {
    std::vector<int> rows(points[k]);
    std::iota(rows.begin(), rows.end(), 0);
    const Model model = read_vtk({{numbers[k], rows}});
    EXPECT_EQ(model.particle_count(), cell_size(types[k]));
    EXPECT_EQ(model.cells.at(0).type, types[k]);
    EXPECT_TRUE(has_note(model.notes, "cells of second or higher order (1): their corners were taken"));
    rows.pop_back();
    EXPECT_TRUE(refuses([&] { read_vtk({{numbers[k], rows}}); }, "cell 0", "points"));
  }
}

/// One of each kind, apart from each other: as long as the table says, or the section would not end where it does.
TEST(MeshKinds, OfSecondOrderElementsOfGmshTheCornersAreTaken) {
  std::ostringstream nodes, elements;
  int node = 0;
  const int types[] = {11, 9, 8, 10, 12, 13, 14, 16, 17, 18, 19}, counts[] = {10, 6, 3, 9, 27, 18, 14, 8, 20, 15, 13};
  for (int k = 0; k < 11; ++k) {
    elements << k + 1 << ' ' << types[k] << " 2 4 1";
    for (int n = 0; n < counts[k]; ++n) {
      nodes << ++node << ' ' << 3 * k + (n & 1) << ' ' << (n >> 1 & 1) << ' ' << (n >> 2 & 1) << '\n';
      elements << ' ' << node;
    }
    elements << '\n';
  }
  const std::string head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(node) + '\n',
                    text = head + nodes.str() + "$EndNodes\n$Elements\n11\n" + elements.str() + "$EndElements\n";
  const Model model = mesh_from_bytes("t.msh", text, {});
  EXPECT_EQ(model.group("volume 4").size(), 4u + 8 + 6 + 5 + 8 + 6 + 5);
  EXPECT_TRUE(has_note(model.notes, "cells of second or higher order (11)"));
  EXPECT_TRUE(has_note(model.notes, "left out (1 line, 2 quad, 1 triangle)"));
}

TEST(MeshKinds, GmshOfVersion1) {
  const std::string text =
      "$NOD\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n9 5 5 5\n$ENDNOD\n"
      "$ELM\n3\n1 4 17 1 4 1 2 3 4\n2 2 6 2 3 1 2 3\n3 15 0 1 1 9\n$ENDELM\n";
  const auto read = [](const std::string& bytes) { return mesh_from_bytes("old.msh", bytes, {}); };
  const Model model = read(text);
  EXPECT_EQ(model.particle_count(), 4);
  EXPECT_EQ(model.group("volume 17").size(), 4u);
  EXPECT_EQ(model.group("surface 6"), (std::vector<Index>{0, 1, 2}));
  EXPECT_TRUE(refuses([&] { read(replaced(text, "$ENDELM", "4 4")); }, "old.msh:14: expected \"$ENDELM\""));
  EXPECT_TRUE(refuses([&] { read(text.substr(0, text.find("$ELM"))); }, "expected a section $ELM"));
}

}  // namespace
}  // namespace phymul::test
