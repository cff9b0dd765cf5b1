// SPDX-License-Identifier: MIT
//
// Meshes whose cells are not all volumes of first order, and Gmsh's first format.
#include <gtest/gtest.h>
#include <phymul/model.h>

#include <numeric>

#include "io/mesh/mesh_parts.h"
#include "support/message_of.h"
#include "support/pml_text.h"

namespace phymul::test {
namespace {

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
