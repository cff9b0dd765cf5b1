// SPDX-License-Identifier: MIT
//
// Surfaces that were altered, in the ways of altered_meshes_test.cpp.
#include <phymul/surface_file.h>

#include <limits>
#include <sstream>

#include "altered_files.h"
#include "support/message_of.h"
#include "support/text_file.h"
#include "surface_files.h"

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
