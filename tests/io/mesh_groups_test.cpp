// SPDX-License-Identifier: MIT
//
// Groups of meshes and their names, files made to take much memory, and options that are refused.
#include <gtest/gtest.h>
#include <phymul/mesh.h>
#include <phymul/pml.h>

#include <cstring>
#include <new>
#include <sstream>

#include "io/mesh/mesh_parts.h"
#include "support/allocation_count.h"
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

}  // namespace
}  // namespace phymul::test
