// SPDX-License-Identifier: MIT
//
// Surfaces from files of every format, written here: the same box comes back, and what is wrong is said by file.
// Surfaces that were altered, in the ways of altered_meshes_test.cpp.
#include <gtest/gtest.h>
#include <phymul/surface_file.h>

#include <filesystem>
#include <limits>
#include <sstream>

#include "altered_files.h"
#include "model/cell_geometry.h"
#include "model/closed_surface.h"
#include "support/message_of.h"
#include "support/text_file.h"
#include "surface_files.h"

namespace phymul::test {
namespace {

std::string reading_surface(const std::string& name, const std::string& bytes, double unit = 1e-3) {
  const TextFile file(name, bytes);
  return message_of([&] { read_surface(file.path(), unit); });
}

/// Whether Assimp, which reads glTF, was there when phymul was built.
bool reads_gltf() {
  return reading_surface("box.gltf", "").find("without Assimp") == std::string::npos;
}

void expect_box(const std::string& name, const std::string& bytes, double unit = 1e-3) {
  SCOPED_TRACE(name);
  const TextFile file(name, bytes);
  Surface surface;
  ASSERT_EQ(message_of([&] { surface = read_surface(file.path(), unit); }), "(no error)");
  EXPECT_EQ(surface.vertices.size(), 8u);
  EXPECT_EQ(surface.triangles.size(), 12u);
  EXPECT_NEAR(enclosed_volume(surface.triangles, surface.vertices), 6e-6, 1e-11);
  Vec3 high = Vec3::Zero();
  for (const Vec3& x : surface.vertices) high = high.cwiseMax(x);
  EXPECT_LT((high - Vec3(0.03, 0.02, 0.01)).norm(), 1e-8);
  EXPECT_TRUE(surface.notes.empty()) << surface.notes.front();
}

TEST(ReadSurface, EveryFormatGivesTheSameBox) {
  struct Format {
    const char* name;
    std::string bytes;
    double unit;
  };
  for (const auto& [name, bytes, unit] : {Format{"box.stl", stl_text(box()), 1e-3},
                                          {"bin.STL", stl_bytes(box()), 1e-3},
                                          {"box.obj", obj_text(box()), 1e-3},
                                          {"box.ply", ply_text(box()), 1e-3},
                                          {"box.gltf", gltf_text(box()), 1.0}}) {
    if (std::string(name) != "box.gltf" || reads_gltf()) expect_box(name, bytes, unit);
  }
}

/// Assimp takes bytes that are line ends for those of the header. Here they are those of the first x, next to 0.
TEST(ReadSurface, BinaryPlyWhoseDataBeginWithALineEnd) {
  const std::string file = ply_bytes();
  const std::size_t data = file.find("end_header\n") + 11;
  const std::string head = file.substr(0, data);
  std::string bytes = file.substr(data);
  for (const std::string first : {"", "\n", "\r", "\r\n", "\n\n", " "}) {
    bytes.replace(0, first.size(), first);
    for (const std::string line_end : {"\n", "\r\n"}) expect_box("box.ply", with_line_ends(head, line_end) + bytes);
  }
}

/// As programs write them that keep faces and lose what the faces name.
TEST(ReadSurface, ObjWithRowsThatDoNotExist) {
  for (const std::string rows : {"/7/9", "//4", "/5", "/", "/-3/-2"}) {
    std::ostringstream text;
    text << "mtllib none.mtl\no box\nvn 0 0 1\nusemtl none\ns off\n# C:\\\n";
    for (const auto& t : box().triangles) {
      for (const Index p : t) text << "  v\t" << box().vertices[p].transpose() << '\n';
      text << "f -3" << rows << " -2" << rows << " \\\n -1" << rows << " # its end\n";  // over two lines
    }
    expect_box("box.obj", with_line_ends(text.str(), "\r\n"));
    expect_box("box.obj", text.str());
  }
}

/// An L of 108 ml, whose six corners do not all see all of it: the same in every order of them.
TEST(ReadSurface, PolygonsThatAreNotConvex) {
  const std::string places =
      "v 0 0 0\nv 100 0 0\nv 100 20 0\nv 20 20 0\nv 20 100 0\nv 0 100 0\n"
      "v 0 0 30\nv 100 0 30\nv 100 20 30\nv 20 20 30\nv 20 100 30\nv 0 100 30\n";
  for (int shift = 0; shift < 6; ++shift) {
    std::string faces, below = "f", above = "f";
    for (int k = 0; k < 6; ++k) {
      const int at = (k + shift) % 6, next = (at + 1) % 6;
      below += ' ' + std::to_string(6 - at);
      above += ' ' + std::to_string(7 + at);
      for (const int row : {at + 1, next + 1, next + 7, at + 7})
        faces += (row == at + 1 ? "\nf " : " ") + std::to_string(row);
    }
    const TextFile file("l.obj", places + below + '\n' + above + faces + '\n');
    const Surface surface = read_surface(file.path(), 1e-3);
    double area = 0.0;
    for (const auto& t : surface.triangles) area += area_vector(t, surface.vertices).norm();
    EXPECT_NEAR(area, 2.0 * 0.0036 + 0.03 * 0.4, 1e-12) << shift;
    EXPECT_NEAR(enclosed_volume(surface.triangles, surface.vertices), 1.08e-4, 1e-15) << shift;
  }
  // A U that no corner sees whole.
  EXPECT_TRUE(says(reading_surface("u.obj",
                                   "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 8 9 0\nv 8 1 0\nv 1 1 0\nv 1 9 0\nv 0 9 0\n"
                                   "f 1 2 3 4 5 6 7 8\n"),
                   "u.obj:9: expected a face that one of its corners sees whole; triangulate on export"));
}

TEST(ReadSurface, GltfThatNeedsWhatIsNotRead) {
  if (!reads_gltf()) GTEST_SKIP() << "phymul was built without Assimp";
  const auto with = [](std::string json, const std::string& names) {
    return json.insert(1, "\"extensionsRequired\" : [" + names + "],");
  };
  expect_box("box.gltf", with(gltf_text(box()), R"("KHR_materials_unlit", "KHR_texture_transform")"), 1.0);
  const std::string names = R"("KHR_materials_unlit", "KHR_mesh_quantization")",
                    wanted = "it needs the glTF extension \"KHR_mesh_quantization\", which is not read";
  EXPECT_TRUE(says(reading_surface("box.gltf", with(gltf_text(box()), names), 1.0), "box.gltf: " + wanted));
  EXPECT_TRUE(says(reading_surface("box.glb", glb_of(with(glb_json(), names), "", ""), 1.0), "box.glb: " + wanted));
}

TEST(ReadSurface, GlbWithChunksThatAreNotFilledUp) {
  if (!reads_gltf()) GTEST_SKIP() << "phymul was built without Assimp";
  std::string json = glb_json();
  for (int spaces = 0; spaces < 4; ++spaces, json += ' ') {
    for (const std::size_t filled : {std::size_t{0}, (4 - json.size() % 4) % 4}) {
      expect_box("box.glb", glb_of(json, std::string(filled, ' '), std::string(1, '\0')), 1.0);
    }
  }
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string whole = glb_of(json, "", "");
  const std::size_t data = 20 + json.size(), size = whole.size() - data - 8;
  EXPECT_TRUE(says(reading_surface("box.glb", whole.substr(0, whole.size() - 10), 1.0),
                   "the chunk at byte " + std::to_string(data) + " says that it has " + std::to_string(size) +
                       " bytes, but the file ends after " + std::to_string(size - 10)));
}

TEST(ReadSurface, SaysWhatItMendedByFile) {
  const TextFile file("box.stl", stl_text(inside_out(box())));
  const Surface surface = read_surface(file.path());  // as if in metres
  ASSERT_EQ(surface.notes.size(), 2u);
  EXPECT_EQ(surface.notes[0], file.path() + ": surface: it was inside out; all triangles were turned");
  EXPECT_TRUE(says(surface.notes[1], "0.001 metres per unit"));
  EXPECT_NEAR(enclosed_volume(surface.triangles, surface.vertices), 6000.0, 1e-9);
}

TEST(ReadSurface, RefusesByFileAndPlace) {
  EXPECT_TRUE(says(reading_surface("box.step", ""),
                   "expected a surface in a .stl, .obj, .ply, .gltf or .glb file, got \".step\""));
  EXPECT_TRUE(says(reading_surface("box.stl", stl_text(box()), 0.0), "metres_per_unit above 0, got 0"));
  EXPECT_TRUE(refuses([] { read_surface("no such file.stl"); }, "no such file.stl: cannot be opened ("));
  const std::string folder = testing::TempDir() + "folder.stl";
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(refuses([&] { read_surface(folder); }, "folder.stl: expected a file, got a folder"));
  std::filesystem::remove(folder);
  Surface open = box();
  open.triangles.pop_back();
  const TextFile file("open.stl", stl_text(open));
  const std::string message = message_of([&] { read_surface(file.path(), 1e-3); });
  EXPECT_EQ(message.find(file.path() + ": surface: expected a closed surface, got 3 open edges, the first from ("), 0u)
      << message;
  for (const auto& [name, bytes] : {std::pair<const char*, std::string>{"cut.stl", stl_bytes(box()).substr(0, 300)},
                                    {"empty.stl", ""},
                                    {"none.stl", "solid none\nendsolid none\n"},
                                    {"torn.ply", ply_text(box()).substr(0, 200)},
                                    {"torn.gltf", gltf_text(box()).substr(0, 300)},
                                    {"nan.stl",
                                     "solid x\nfacet normal 0 0 0\nouter loop\nvertex nan 0 0\nvertex 1 0 0\n"
                                     "vertex 0 1 0\nendloop\nendfacet\nendsolid x\n"}}) {
    const std::string refusal = reading_surface(name, bytes);
    EXPECT_TRUE(says(refusal, std::string(name) + ":"));
  }
  EXPECT_TRUE(says(reading_surface("torn.ply", ply_text(box()).substr(0, 200)), "torn.ply:16: expected a coordinate"));
  EXPECT_TRUE(says(reading_surface("nan.stl", with_line_ends(stl_text(box()), "\n nan")), "nan.stl:2: expected facet"));
}

}  // namespace
}  // namespace phymul::test

#ifdef __SANITIZE_ADDRESS__
/// Assimp 5.2 keeps a few hundred bytes of its own where it gives up a damaged glTF, Teem 1.12 the stream of a damaged
/// compressed NRRD.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libassimp.so\nleak:libteem.so\n";
}
#endif

namespace phymul::test {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();

std::string read_altered_surface(const std::string& name, const std::string& bytes) {
  const TextFile file(name, bytes);
  Surface surface = read_surface(file.path());
  const std::size_t triangles = surface.triangles.size();
  mend_surface(surface);
  EXPECT_EQ(surface.triangles.size(), triangles);
  std::ostringstream out;
  for (const Vec3& x : surface.vertices) out << x.transpose() << '\n';
  for (const auto& [a, b, c] : surface.triangles) out << a << ' ' << b << ' ' << c << '\n';
  return out.str();
}

TEST(AlteredSurfaces, Stl) {
  AlteredFiles text("box.stl", stl_text(box()), read_altered_surface);
  text.alter(R"(
= vertex 30 | vertex  30 | vertex 3e1   = solid box | solid | solid box in millimetres   = endsolid box | endsolid
! vertex 30 | vertex nan | vertex inf | vertex 1e39 | vertex | vertex x | vertex 30 30 | vertex 30x
! vertex 30 | vertex 30 20 0\nvertex 30
! vertex 30 20 0\n | _   ! facet normal | facet   ! endloop | _   ! endfacet | _   ! endsolid box | _   ! outer loop | _)");
  text.damage_text(15, 20);
  text.damage_lines(100);
  AlteredFiles binary("bin.stl", stl_bytes(box()), read_altered_surface);
  binary.hold("a head as of a text", "solid box" + binary.bytes().substr(9), Must::be_same);
  binary.hold("a byte too many", binary.bytes() + ' ', Must::either);
  binary.put<std::uint32_t>(80, {0, 11, 13, 0xffffffff, 1 << 30, 12 << 24}, Must::fail);  // triangles
  binary.put<float>(146, {infinity, nan}, Must::fail);
  binary.damage(12, 20);
  binary.damage_bytes(200);
}

TEST(AlteredSurfaces, Obj) {
  AlteredFiles obj("box.obj", obj_text(box()), read_altered_surface);
  const std::string last_face = obj.bytes().substr(obj.bytes().rfind("f "));
  obj.hold("comments", "# a box\n" + with_line_ends(obj.bytes(), " # a row\n"), Must::be_same);
  obj.hold("faces first", obj.bytes().substr(obj.bytes().find("f ")) + obj.bytes().substr(0, obj.bytes().find("f ")),
           Must::either);
  for (const char* face : {"f 1 2", "f 1", "f", "f 1 2 9", "f 1 2 0", "f 1 2 -9", "f 1 2 99999999999", "f 1 2 x",
                           "f 1 2.5 3", "f 1 2 nan", "f 1 2 4294967299", "f 1 2 -4294967293", "f a b c", "f 1,2,3"}) {
    obj.hold(face, obj.bytes().substr(0, obj.bytes().size() - last_face.size()) + face + '\n', Must::fail);
  }
  obj.hold("a face twice", obj.bytes() + last_face, Must::any);
  obj.alter(R"(
= v 30 20 10 | v 3e1 20. +10 | v 30 20 10 1 | v 30 20 10 0.5 0.5 0.5
! v 30 20 10 | v 30 20 | v | v 30 20 nan | v 30 20 inf | v 30 20 1e999 | v 30 20 ten | v 30 20 10x | v 30 20 1.0.0
! v 30 20 10 | v 30 20 0x10 | v 30 20 10,5 | vn 30 20 10
! v 30 20 10\n | _)");
  obj.damage_text(100, 320);
  obj.damage_lines(100, Must::either, obj.bytes().find("f "));
}

TEST(AlteredSurfaces, Ply) {
  AlteredFiles text("box.ply", ply_text(box()), read_altered_surface);
  text.alter(R"(
= element vertex | comment in millimetres\nelement vertex   ! float z | float z\nproperty float nx
= float x | double x
! vertex 8 | vertex 7 | vertex 9 | vertex 0 | vertex -8 | vertex 4000000000 | vertex 99999999999999999999
! vertex 8 | vertex eight
! face 12 | face 11 | face 13 | face 0 | face -12 | face 4000000000   ! end_header\n | _   ! property float z\n | _
! float y | float z   ! element face | element side   ! vertex_indices | corners
! ascii | binary_little_endian | binary_big_endian   ! ascii 1.0 | utf8 1.0   ! ply\n | pla\n
! \n30 20 10 | \n30 20 nan | \n30 20 inf | \n30 20 | \n30 20 ten | \n30 20 10,5 | \n30 20 10x
! \n3 0 | \n2 0 | \n4 0 | \n-3 0 | \n255 0 | \nx 0)");
  const std::string head = text.bytes().substr(0, text.bytes().rfind("3 "));
  for (const char* face : {"3 0 1 8", "3 0 1 -1", "3 0 1 4294967296", "3 0 1 x", "3 0 1 2.5", "3 0 1", "3"}) {
    text.hold(face, head + face + '\n', Must::fail);
  }
  text.damage_text(15, 20);
  text.damage_lines(100);
  AlteredFiles binary("bin.ply", ply_bytes(), read_altered_surface);
  const std::string other_way = ply_bytes(true);
  binary.hold("the other order, not said", other_way, Must::fail);
  std::string said = other_way;
  binary.hold("the other order", said.replace(said.find("little"), 6, "big"), Must::be_same);
  binary.alter(R"(
! little | big   ! vertex 8 | vertex 7 | vertex 9 | vertex 4000000000
! face 12 | face 13 | face 11 | face 4000000000   ! float x | double x   ! uchar int | int int | uchar short)");
  binary.damage(12, 25);
  binary.damage_bytes(120);
}

TEST(AlteredSurfaces, Gltf) {
  const std::string reading = message_of([] { read_altered_surface("box.gltf", gltf_text(box())); });
  if (says(reading, "without Assimp")) GTEST_SKIP() << reading;
  AlteredFiles text("box.gltf", gltf_text(box()), read_altered_surface);
  text.alter(R"(
= {"asset" | { "asset"   ! "asset":{"version":"2.0"} | "asset":{"version":"7.0"}   = "scene":0, | _
! "scene":0, | "scene":1, | "scene":-1,   ! "nodes":[0] | "nodes":[1] | "nodes":[-1]   ? "nodes":[0] | "nodes":[0,0]
! {"mesh":0 | {"children":[0],"mesh":0 | {"mesh":1   ! "POSITION":0 | "POSITION":2 | "POSITION":1 | "NORMAL":0
! "indices":1 | "indices":2 | "indices":0   ! "count":8 | "count":9 | "count":7 | "count":0 | "count":-8 | "count":1e30
! "count":8 | "count":4000000000
! "count":36 | "count":37 | "count":33 | "count":35 | "count":4294967332   ? 5126 | 5125   ! 5126 | 5120 | 9
! 5125 | 5123   ? 5125 | 5126   ! SCALAR | VEC3   ! "bufferView":1 | "bufferView":2 | "bufferView":0
! "byteOffset":96 | "byteOffset":92 | "byteOffset":9600 | "byteOffset":-96 | "byteOffset":18446744073709551520
! "byteLength":96 | "byteLength":95 | "byteLength":99999999999   ! "buffer":0 | "buffer":1   ! 0.001 | 1e999 | 0
! base64, | ,)");
  text.damage(15, 20, Must::either, Must::any, 0, text.bytes().find("base64"));
  text.damage_bytes(150, Must::either, text.bytes().find("base64"));
  AlteredFiles glb("box.glb", glb_of(glb_json() + ' ', std::string((4 - (glb_json().size() + 1) % 4) % 4, ' '), ""),
                   read_altered_surface);
  for (const std::size_t at : {std::size_t{0}, std::size_t{4}, std::size_t{8}, std::size_t{12}, std::size_t{16},
                               glb.bytes().find("BIN") - 4, glb.bytes().find("BIN")}) {
    glb.put<std::uint32_t>(at, {0, 1, 0x7fffffff, 0xffffffff}, at == 8 ? Must::either : Must::fail);
  }
  glb.damage(12, 25);
  glb.damage_bytes(100);
}

}  // namespace
}  // namespace phymul::test
