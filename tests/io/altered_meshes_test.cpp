// SPDX-License-Identifier: MIT
//
// Files that were altered: what must come of each is known.
#include <phymul/phymul.h>

#include <limits>
#include <sstream>

#include "altered_files.h"
#include "base/checked_file.h"
#include "io/mesh/mesh_parts.h"
#include "label_files.h"
#include "session/scene_bytes.h"
#include "support/pml_text.h"
#include "support/text_file.h"

namespace phymul::test {
namespace {

/// All that a file says of a body.
std::string text_of_model(const Model& model) {
  validate(model);
  std::ostringstream out;
  out << std::hexfloat << model.dimension << '\n';
  for (Index i = 0; i < model.particle_count(); ++i) {
    const Vec3& x = model.rest[i];
    out << x.x() << ' ' << x.y() << ' ' << x.z() << ' ' << model.mass[i] << ' ' << model.stiffness[i] << ':';
    for (const Index j : std::vector<Index>(model.neighbours.begin(i), model.neighbours.end(i))) out << ' ' << j;
    out << '\n';
  }
  for (const Cell& cell : model.cells) {
    out << cell_name(cell.type);
    for (const Index p : cell.particles) out << ' ' << p;
    out << '\n';
  }
  for (const Component& part : model.components) {
    out << part.name;
    for (const auto* rows : {&part.cells, &part.cell_refs, &part.particles}) {
      out << " |";
      for (const Index row : *rows) out << ' ' << row;
    }
    out << '\n';
  }
  return out.str();
}

std::string read_altered_mesh(const std::string& name, const std::string& bytes) {
  return text_of_model(mesh_from_bytes(name, bytes, {}));
}

AlteredFiles sample_mesh(const std::string& name) {
  return {name, text_of(test_data + "/mesh/" + name), read_altered_mesh};
}

TEST(AlteredMeshes, Vtk) {
  AlteredFiles old = sample_mesh("mixed_42.vtk");
  old.hold("point data", old.bytes() + "POINT_DATA 12\nSCALARS a float\n", Must::be_same);
  old.alter(R"(
= POINTS 12 | points  12   = \n\nCELLS | \nMETADATA\nINFORMATION 0\n\nCELLS
! POINTS 12 | POINTS 13 | POINTS 11 | POINTS -12 | POINTS 99999999999999999999 | POINTS 4000000000
! POINTS 12 double | POINTS double   ! CELLS 8 41 | CELLS 9 41 | CELLS 7 41 | CELLS 7 36 | CELLS 8 40 | CELLS -8 41
! CELLS 8 41 | CELLS 8 4000000000   ! CELL_TYPES 8 | CELL_TYPES 9 | CELL_TYPES -1
! CELL_TYPES 8 | CELL_TYPES 8\n1\n3\n5\n9\n12\n13\n10\n14\nCELL_TYPES 8
! \n2 10 11 | \n2 10 12 | \n2 10 -1 | \n2 10 4294967306 | \n3 10 11 | \n-2 10 11
! 1.7 | nan | -inf | 1,7 | 1e999 | 1.7.1 | 0x1.8p0   ! ASCII | BINARY | TEXT   ! \n14 | \n0 | \n-14 | \n4294967310
! # vtk DataFile | # vtk   ! DATASET UNSTRUCTURED_GRID | DATASET POLYDATA)");
  old.damage_text(15, 20);
  old.damage_lines(100);

  AlteredFiles newer = sample_mesh("mixed_51.vtk");
  newer.alter(R"(! CELLS 9 33 | CELLS 9 34 | CELLS 9 32 | CELLS 8 33 | CELLS 10 33 | CELLS 0 0   ! 28 33 | 28 32 | 28 34
! 0 1 3 | 0 -1 3 | 1 1 3   ! OFFSETS vtktypeint64 | OFFSETS   ! CONNECTIVITY | CONNECTIONS)");
  newer.damage_text(10, 10);
  newer.damage_lines(100);
  AlteredFiles open_ended("t.vtk",
                          "# vtk DataFile Version 5.1\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                          "0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 3 6\nOFFSETS int\n0 4 6\nCONNECTIVITY int\n0 1 2 3 2 3\n"
                          "CELL_TYPES 2\n10\n2\n",
                          read_altered_mesh);
  open_ended.alter(R"(! 0 4 6 | 0 4 5 | 0 4 7)");
  for (const char* name : {"mixed_42_binary.vtk", "mixed_51_binary.vtk"}) {
    AlteredFiles binary = sample_mesh(name);
    binary.alter(R"(! BINARY | ASCII   ! POINTS 12 | POINTS 13 | POINTS 11   ! double | float)");
    binary.damage(12, 25);
    binary.damage_bytes(60);
  }
}

TEST(AlteredMeshes, Vtu) {
  AlteredFiles text = sample_mesh("mixed_ascii.vtu");
  text.alter(R"(
= <Cells> | <!-- of eight kinds --><Cells>   = \n          0 0 0 1 | <!-- in metres -->\n          0 0 0 1
= 1 1 0 0 1 0 | 1 1 0 <!-- four -->0 1 0   = LittleEndian | BigEndian   ! LittleEndian | MiddleEndian
= UInt64 | UInt32
! NumberOfPoints="12" | NumberOfPoints="13" | NumberOfPoints="11" | NumberOfPoints="-12"
! NumberOfPoints="12" | NumberOfPoints="18446744073709551615" | NumberOfPoints="1e1" | NumberOfPoints="0"
! NumberOfPoints="12" | NumberOfPoints="12" NumberOfPoints="12"
! NumberOfPoints="12" N | N
! NumberOfCells="8" | NumberOfCells="7" | NumberOfCells="9" | NumberOfCells="0" | NumberOfCells="4611686018427387905"
! 0.5 0.5 1.7 | 0.5 0.5 1.7 0 | 0.5 0.5 | 0.5 0.5 nan | 0.5 0.5 1,7 | 0.5 0.5 1.7.0
! 11 10 11 | 12 10 11 | -1 10 11 | 11 11 10 11   ! 28 33 | 28 32 | 28 34 | 28 33 33
! 10 14\n | 10 14 14\n | 10\n | 10 0\n   ! <Points> | <Points/><Points>
! <Cells> | <Cells></Cells><Cells> | <Cells><DataArray type="UInt8" Name="types">1 3 5 9 12 13 14 10</DataArray>
! Name="types" | Name="kinds"   ! Name="offsets" | Name="types"
! type="Float64" | type="Float64" type="Int64" | type="Float16"   ! format="ascii" | format="binary"
!   </UnstructuredGrid> |   </UnstructuredGrid><UnstructuredGrid/>
! <UnstructuredGrid> | <UnstructuredGrid></UnstructuredGrid><UnstructuredGrid>)");
  text.damage_text(15, 20);
  text.damage_lines(100);
  for (const char* name :
       {"mixed_appended64.vtu", "mixed_base64_zlib.vtu", "mixed_raw.vtu", "mixed_raw_zlib_big.vtu"}) {
    AlteredFiles coded = sample_mesh(name);
    const bool big = coded.bytes().find("BigEndian") != std::string::npos;
    const bool wide = coded.bytes().find("UInt64\"") < coded.bytes().find("<Piece");
    const std::string order = big ? "BigEndian | LittleEndian" : "LittleEndian | BigEndian";
    coded.alter("! " + order + (wide ? "   ! UInt64 | UInt32" : "   ! UInt32 | UInt64"));
    coded.alter(
        R"(! NumberOfPoints="12" | NumberOfPoints="11" | NumberOfPoints="999999999999"   ! NumberOfCells="8" | NumberOfCells="7"
! Float64 | Float32)");
    coded.damage(12, 25);
    coded.damage_bytes(60);
  }
}

TEST(AlteredMeshes, Gmsh) {
  AlteredFiles four = sample_mesh("mixed_41.msh");
  const std::size_t elements = four.bytes().find("$Elements");
  four.hold("elements twice", four.bytes() + four.bytes().substr(elements), Must::fail);
  four.hold("no nodes", four.bytes().substr(0, four.bytes().find("$Nodes")) + four.bytes().substr(elements),
            Must::fail);
  four.alter(R"(
= $Nodes | $Comments\nof eight kinds\n$EndComments\n$Nodes   ! 4.1 0 8 | 4.0 0 8 | 4.1 1 8 | 2.2 0 8
~ $PhysicalNames | $MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames
! $Nodes | $MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes   ~ $Nodes | $Entities\n0 0 0 0\n$EndEntities\n$Nodes
! 2 13 1 30 | 2 14 1 30 | 2 12 1 30 | 1 13 1 30 | 3 13 1 30 | 1000000000 13 1 30 | -2 13 1 30
! 3 1 0 10 | 3 1 0 9 | 3 1 0 11 | 3 1 1 10   ! 8 8 1 8 | 8 9 1 8 | 8 7 1 8 | 7 8 1 8 | 9 8 1 8
! 3 1 5 1\n5 | 3 1 5 2\n5 | 3 1 5 99999999999\n5 | 3 1 4 1\n5   ! 2 21 22 | 2 21 23 | 2 21 -22 | 2 21 0
! 1.5 0.5 1\n | 1.5 0.5 inf\n | 1.5 0,5 1\n | 1.5 0.5\n   ! $EndNodes | $Endnodes)");
  four.damage_text(15, 20);
  four.damage_lines(100);

  AlteredFiles two = sample_mesh("mixed_22.msh");
  two.hold("elements twice", two.bytes() + two.bytes().substr(two.bytes().find("$Elements")), Must::fail);
  two.alter(R"(! $Nodes\n12 | $Nodes\n11 | $Nodes\n13 | $Nodes\n-12
! $Elements\n10 | $Elements\n9 | $Elements\n11 | $Elements\n4000000000
! 1 15 2 1 7 12 | 1 15 1 1 7 12 | 1 15 3 1 7 12 | 1 15 -2 1 7 12 | 1 15 2 1 7 99 | 1 1 2 1 7 12
! 2.2 0 8 | 4.1 0 8 | 2.2 1 8 | 3 0 8)");
  two.damage_text(10, 10);
  two.damage_lines(100);
  for (const char* name : {"mixed_41_binary.msh", "mixed_22_binary.msh"}) {
    AlteredFiles binary = sample_mesh(name);
    binary.alter(R"(!  1 8\n |  0 8\n |  2 8\n   ! $EndNodes | $EndNode)");
    binary.damage(12, 25);
    binary.damage_bytes(60, Must::either, binary.bytes().find("$Nodes"));
  }
  AlteredFiles one("old.msh",
                   "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n"
                   "$ELM\n2\n1 4 17 1 4 1 2 3 4\n2 2 6 2 3 1 2 3\n$ENDELM\n",
                   read_altered_mesh);
  one.alter(
      R"(! $NOD\n4 | $NOD\n3 | $NOD\n5   ! $ELM\n2 | $ELM\n1 | $ELM\n3   ! 17 1 4 1 2 | 17 1 5 1 2 | 17 1 3 1 2 | 17 1 4 1 9)");
}

/// A small body with everything that the reader knows.
std::string rich_pml() {
  const std::string colour = "<color r=\"0.1\" g=\"0.2\" b=\"0.3\" a=\"0.4\"/>";
  const std::string after =
      "<informativeComponents>\n<multiComponent name=\"I\">\n<multiComponent name=\"J\">\n"
      "<structuralComponent name=\"G\" mode=\"NONE\">\n<cellRef index=\"4\"/>\n<atomRef index=\"2\"/>\n"
      "</structuralComponent>\n</multiComponent>\n<structuralComponent name=\"Neighborhoods\" stiffness=\"2\" "
      "mass=\"1\">\n" +
      cell_text("POLY_VERTEX", {1, 2, 3}, "name=\"Atom #0\" index=\"50\" eta=\"x\"", colour) + "\n" +
      cell_text("POLY_VERTEX", {0, 2, 3}, "name=\"Atom #1\" stiffness=\"4\"") + "\n" +
      cell_text("POLY_VERTEX", {0, 1}, "name=\"Atom #3\" phymul=\"unnumbered\"") +
      "\n</structuralComponent>\n</multiComponent>\n</informativeComponents>\n";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!DOCTYPE physicalModel>\n" +
         replaced(pml_text(tetrahedron_atoms,
                           {colour,
                            cell_text("TETRAHEDRON", {0, 1, 2, 3},
                                      "index=\"4\" young=\"1e3\" poisson=\"0.4\" density=\"1000\" phymul=\"row=1\""),
                            cell_text("LINE", {0, 3}, "index=\"5\" phymul=\"row=0\""), "<unknown a=\"&amp;&#10;\"/>"},
                           after, "comment=\"c\" nrOfAtoms=\"4\""),
                  "z=\"0\"/>", "z=\"0\" name=\"tip\" fixed=\"1\" mass=\"2\"/>");
}

TEST(AlteredMeshes, Pml) {
  const auto read = [](const std::string& name, const std::string& bytes) {
    const Model model = read_pml_text(bytes, name);
    std::string once;  // a reference to a control character is read but cannot be written
    const bool is_written = message_of([&] { once = written(model); }) == "(no error)";
    EXPECT_TRUE(!is_written || read_pml_text(once, "again.pml") == model) << once;
    return text_of_model(model);
  };
  AlteredFiles pml("a.pml", pml_text(tetrahedron_atoms, {tetrahedron_cell}, "", "nrOfAtoms=\"4\""), read);
  pml.hold("byte order mark", "\xEF\xBB\xBF" + pml.bytes(), Must::be_same);
  pml.alter(R"(
= <atoms> | <!-- of a tetrahedron --><atoms>   = nrOfAtoms="4" | nrOfAtoms="4000000000"   = x="1" y | x="1.0e0" y
! x="1" y | x="nan" y | x="inf" y | x="1e999" y | x="1,0" y | x="" y | y | x="1" x="2" y
! <atomRef index="3"/> | <atomRef index="4"/> | <atomRef index="-1"/> | <atomRef index="4294967299"/> | _
! <atomRef index="3"/> | <atomRef index="3.0"/> | <atomRef index="3" index="2"/>   ? "3"/></cell> | "2"/></cell>
! index="3" x | index="2" x | index="-3" x | index="99999999999" x   ! physicalModel name | loads name
! TETRAHEDRON | PYRAMID | tetrahedron   ! <atoms> | <atoms></atoms><atoms>
! <exclusiveComponents> | <exclusiveComponents/><exclusiveComponents>)");
  pml.damage_text(15, 20);
  pml.damage_lines(100, Must::any);
  AlteredFiles("rich.pml", rich_pml(), read).damage(40, 400);
}

const char* const rich_lml =
    "<loads xmlns:xsi='x'>\n<load xsi:type='Translation'>\n<appliedTo>1, 2,3-5</appliedTo>\n"
    "<valueEvent date='0' value='1'/>\n<valueEvent date='1e0' value='-2.5'/>\n<direction x='NULL' y='1'/>\n"
    "<unit>micron</unit>\n</load>\n<load type='Pressure'>\n<?phymul generated?>\n<appliedTo>*</appliedTo>\n"
    "<valueEvent date='0' value='1'/>\n<unit>mmHg</unit>\n</load>\n<load xsi:type='Force'>\n"
    "<appliedTo>Tip</appliedTo>\n<valueEvent date='0.5' value='3'/>\n<direction toward='7'/>\n<unit>pN</unit>\n"
    "</load>\n</loads>\n";

TEST(AlteredMeshes, Lml) {
  static const Model body = make_block({0.04, 0.01, 0.01}, 4, 1, 1).add_group("Tip", {3, 1});
  const auto read = [](const std::string& name, const std::string& bytes) {
    const std::vector<Load> loads = read_lml_text(bytes, name, body);
    std::ostringstream out;
    if (message_of([&] { write_lml(loads, body, out); }) == "(no error)") {
      EXPECT_EQ(read_lml_text(out.str(), "again.lml", body), loads);
    }
    return out.str();
  };
  AlteredFiles lml(
      "a.lml",
      "<loads>\n<load type='Force'>\n<appliedTo>1,3-5</appliedTo>\n<valueEvent date='0' value='1'/>\n"
      "<valueEvent date='1' value='2.5'/>\n<direction x='0' y='1' z='0'/>\n<unit>N</unit>\n</load></loads>\n",
      read);
  lml.alter(R"(
= <load type | <!-- a pull --><load type   ? 1,3-5 | 1, 3 - 5 | 1,3,4,5
! 1,3-5 | 1,5-3 | 1,3-9999999999 | 1,-3 | 1,,3 | 1.5 | none   ! 2.5 | nan | inf | 2,5 | 1e999
! date='1' | date='1' date='2' | _   ! y='1' | y='0' | y='NaN'   ! <unit>N | <unit>mm | <unit>kN</unit><unit>N
! type='Force' | type='Torque'   ! <loads> | <physicalModel>)");
  lml.damage_text(15, 20);
  lml.damage_lines(100, Must::any);
  AlteredFiles("rich.lml", rich_lml, read).damage(40, 400);
}

// Labelled images, states and recordings, altered in the same ways.

std::string read_altered_labels(const std::string& name, const std::string& bytes) {
  const LabelImage image = read_back(name, bytes);
  EXPECT_EQ(image.label.size(), std::size_t(image.size[0]) * std::size_t(image.size[1]) * std::size_t(image.size[2]));
  std::ostringstream out;
  out << image.size[0] << ' ' << image.size[1] << ' ' << image.size[2] << " from " << image.origin.transpose() << " by";
  for (const Vec3& step : image.step) out << ' ' << step.transpose();
  for (const std::uint16_t label : image.label) out << ' ' << label;
  return out.str();
}

TEST(AlteredLabels, Nifti) {
  PHYMUL_SKIP_UNLESS_READ("a.nii");
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  Nifti framed;
  framed.sform({1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7});
  AlteredFiles file("a.nii", Nifti().bytes(), read_altered_labels);
  std::string swapped = file.bytes();
  for (const auto& [at, size, count] :
       {std::array<std::size_t, 3>{0, 4, 1}, {40, 2, 8}, {70, 2, 2}, {76, 4, 9}, {352, 2, 24}}) {
    for (std::size_t k = 0; k < count; ++k) {
      const auto first = swapped.begin() + static_cast<std::ptrdiff_t>(at + k * size);
      std::reverse(first, first + static_cast<std::ptrdiff_t>(size));
    }
  }
  file.hold("the other byte order", swapped, Must::be_same);
  file.put<std::int32_t>(0, {540, 0, -1}, Must::either);
  file.put<std::int16_t>(40, {0, -3, 2, 8, 32767}, Must::fail);  // dimensions
  file.put<std::int16_t>(40, {4}, Must::be_same);
  file.put<std::int16_t>(42, {0, -4, 5, 32767}, Must::fail);
  file.put<std::int16_t>(70, {0, 1, 2, 8, 16, 64, 128, 256, 1024, 4096}, Must::fail);  // types not of 16 bits
  file.put<std::int16_t>(70, {512}, Must::be_same);
  file.put<float>(80, {0.0f, nan, infinity}, Must::any);                                  // widths of voxels
  file.put<float>(108, {0.0f, -1.0f, nan, infinity, 1e30f, 354.0f, 400.0f}, Must::fail);  // where the voxels begin
  file.put<float>(112, {2.0f}, Must::fail);                                               // a scale
  file.put<char>(345, {'i', '-'}, Must::fail);
  file.damage(12, 20, Must::fail);
  file.damage_bytes(150);
  AlteredFiles("b.nii", framed.bytes(), read_altered_labels).put<float>(280, {0.0f, nan, infinity}, Must::fail);
  Nifti large;  // enough that zlib could stop before the checksum
  large.dimensions({3, 64, 32, 20, 1, 1, 1, 1});
  std::vector<std::int16_t> noise(64 * 32 * 20);
  std::mt19937 random(3);
  for (std::int16_t& label : noise) label = static_cast<std::int16_t>(random() % 8);
  large.voxels = bytes_of(noise);
  for (const std::string& bytes : {framed.bytes(), large.bytes()}) {
    AlteredFiles zip("a.nii.gz", zipped(bytes), read_altered_labels);
    zip.damage(15, 40, Must::either, Must::either, 10);
    zip.damage_bytes(60, Must::either, 10);
  }
}

TEST(AlteredLabels, Nrrd) {
  PHYMUL_SKIP_UNLESS_READ("a.nrrd");
  AlteredFiles file("a.nrrd", nrrd(plain + raw + "spacings: 1 2 3\n"), read_altered_labels);
  file.alter(R"(
= type: short | # labels\ntype: short | type: int16   ~ NRRD0004 | NRRD0001   ! NRRD0004 | NRRD0009 | NRRX0004
! type: short | type: int | type: float | type: long long int | type: short\ntype: int   ! type: short\n | _
! dimension: 3 | dimension: 2 | dimension: 4 | dimension: 0   ! dimension: 3\n | _
! sizes: 4 | sizes: 5 | sizes: 0 | sizes: -4 | sizes: 4000000000   ! sizes: 4 3 2 | sizes: 4 3 | sizes: 4 3 2 1
! endian: little\n | _   ! endian: little | endian: middle
! encoding: raw | encoding: gzip | encoding: text | encoding: hex   ! encoding: raw\n | _
! spacings: 1 2 3 | spacings: 0 2 3 | spacings: 1 inf 3 | spacings: 1 2 | spacings: a b c)");
  file.hold("a voxel too many", file.bytes() + std::string(2, '\0'), Must::either);
  file.damage(12, 20, Must::fail);
  file.damage_bytes(150, Must::either, file.bytes().find("\n\n"));
  AlteredFiles zip("b.nrrd", nrrd(plain + "encoding: gzip\n", zipped(bytes_of(counted()))), read_altered_labels);
  zip.damage(12, 60, Must::either, Must::either, zip.bytes().find("\n\n") + 12);
  zip.damage_bytes(40);
}

TEST(AlteredStates, FilesAndRecordings) {
  Simulation sim(make_block({0.02, 0.02, 0.02}, 1, 1, 1));
  sim.record();
  sim.advance(0.01);
  const TextFile state("a.state", ""), recording("a.rec", "");
  sim.save(state.path());
  save_recording(sim.recording(), recording.path());
  const auto text_of_snapshot = [](const Snapshot& snapshot) {
    ByteWriter out;
    put_snapshot(out, snapshot);
    return out.bytes();
  };
  const std::string state_bytes = text_of(state.path()), recording_bytes = text_of(recording.path());
  AlteredFiles one("a.state", state_bytes, [&](const std::string& name, const std::string& bytes) {
    const TextFile file(name, bytes);
    return text_of_snapshot(read_state(file.path()));
  });
  AlteredFiles two("a.rec", recording_bytes, [&](const std::string& name, const std::string& bytes) {
    const TextFile file(name, bytes);
    const Recording read = read_recording(file.path());
    return text_of_snapshot(read.start) + read.scene + std::to_string(read.inputs.size());
  });
  for (AlteredFiles* file : {&one, &two}) {
    file->damage(15, 30, Must::fail, Must::fail);
    file->damage_bytes(230, Must::fail);
    file->hold("twice", file->bytes() + file->bytes(), Must::fail);
    file->hold("a byte more", file->bytes() + 'x', Must::fail);
  }
}

}  // namespace
}  // namespace phymul::test
