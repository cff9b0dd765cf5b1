// SPDX-License-Identifier: MIT
//
// Surfaces from files of every format, written here: the same box comes back, and what is wrong is said by file.
#include <phymul/surface_file.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "body/body_shapes.h"
#include "model/enclosed_volume.h"
#include "support/message_of.h"
#include "support/text_file.h"

namespace phymul::test {
namespace {

/// 30 x 20 x 10, as a file in millimetres has it.
Surface box() {
  return box_surface({0, 0, 0}, {30, 20, 10});
}

std::string stl_text(const Surface& surface) {
  std::ostringstream out;
  out << "solid box\n";
  for (const auto& t : surface.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const Index p : t) out << "vertex " << surface.vertices[p].transpose() << '\n';
    out << "endloop\nendfacet\n";
  }
  out << "endsolid box\n";
  return out.str();
}

void append_float(std::string& bytes, double value) {
  const auto number = static_cast<float>(value);
  char own[4];
  std::memcpy(own, &number, 4);
  bytes.append(own, 4);
}

std::string stl_bytes(const Surface& surface) {
  std::string bytes(80, ' ');
  const auto count = static_cast<std::uint32_t>(surface.triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& t : surface.triangles) {
    bytes.append(12, '\0');
    for (const Index p : t) {
      for (const double x : surface.vertices[p]) append_float(bytes, x);
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

std::string obj_text(const Surface& surface) {
  std::ostringstream out;
  for (const Vec3& x : surface.vertices) out << "v " << x.transpose() << '\n';
  for (const auto& [a, b, c] : surface.triangles) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
  return out.str();
}

std::string ply_text(const Surface& surface) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << surface.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << surface.triangles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& x : surface.vertices) out << x.transpose() << '\n';
  for (const auto& [a, b, c] : surface.triangles) out << "3 " << a << ' ' << b << ' ' << c << '\n';
  return out.str();
}

std::string base64(const std::string& bytes) {
  const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : letters[word >> (18 - 6 * k) & 63];
  }
  return text;
}

/// Places, then what `append` makes of the triangles.
template <class Append>
std::string box_bytes(const Append& append) {
  std::string bytes;
  for (const Vec3& x : box().vertices) {
    for (const double value : x) append_float(bytes, value);
  }
  for (const auto& t : box().triangles) append(bytes, std::string(reinterpret_cast<const char*>(t.data()), 12));
  return bytes;
}

/// In metres by a node that scales it.
std::string gltf_text(const Surface& surface) {
  const std::string bytes = box_bytes([](std::string& out, const std::string& rows) { out += rows; });
  const std::size_t places = 12 * surface.vertices.size();
  std::ostringstream out;
  out << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
      << R"("nodes":[{"mesh":0,"scale":[0.001,0.001,0.001]}],)"
      << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[)"
      << R"({"bufferView":0,"componentType":5126,"count":)" << surface.vertices.size()
      << R"(,"type":"VEC3","min":[0,0,0],"max":[30,20,10]},{"bufferView":1,"componentType":5125,"count":)"
      << 3 * surface.triangles.size() << R"(,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":)" << places
      << R"(},{"buffer":0,"byteOffset":)" << places << R"(,"byteLength":)" << bytes.size() - places
      << R"(}],"buffers":[{"byteLength":)" << bytes.size() << R"(,"uri":"data:application/octet-stream;base64,)"
      << base64(bytes) << R"("}]})";
  return out.str();
}

std::string reading_surface(const std::string& name, const std::string& bytes, double unit = 1e-3) {
  const TextFile file(name, bytes);
  return message_of([&] { read_surface(file.path(), unit); });
}

bool is_built() {
  return reading_surface("box.obj", obj_text(box())).find("without Assimp") == std::string::npos;
}

#define SKIP_WITHOUT_ASSIMP() \
  if (!is_built()) GTEST_SKIP() << "phymul was built without Assimp"

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
  SKIP_WITHOUT_ASSIMP();
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
    expect_box(name, bytes, unit);
  }
}

std::string with_line_ends(const std::string& text, const std::string& line_end) {
  std::string out;
  for (const char c : text) out += c == '\n' ? line_end : std::string(1, c);
  return out;
}

/// Assimp takes bytes that are line ends for those of the header. Here they are those of the first x, next to 0.
TEST(ReadSurface, BinaryPlyWhoseDataBeginWithALineEnd) {
  SKIP_WITHOUT_ASSIMP();
  std::string head = ply_text(box());
  head.resize(head.find("end_header\n") + 11);
  head.replace(head.find("ascii"), 5, "binary_little_endian");
  std::string bytes = box_bytes([](std::string& out, const std::string& rows) { out += '\3' + rows; });
  for (const std::string first : {"", "\n", "\r", "\r\n", "\n\n", " "}) {
    bytes.replace(0, first.size(), first);
    for (const std::string line_end : {"\n", "\r\n"}) expect_box("box.ply", with_line_ends(head, line_end) + bytes);
  }
}

/// As programs write them that keep faces and lose what the faces name.
TEST(ReadSurface, ObjWithRowsThatDoNotExist) {
  SKIP_WITHOUT_ASSIMP();
  for (const std::string rows : {"/7/9", "//4", "/5", "/", "/-3/-2"}) {
    std::ostringstream text;
    text << "mtllib none.mtl\no box\nvn 0 0 1\nusemtl none\ns off\n# C:\\\n";
    for (const auto& t : box().triangles) {
      for (const Index p : t) text << "  v\t" << box().vertices[p].transpose() << '\n';
      text << "f -3" << rows << " -2" << rows << " \\\n -1" << rows << '\n';  // over two lines
    }
    expect_box("box.obj", with_line_ends(text.str(), "\r\n"));
    expect_box("box.obj", text.str());
  }
}

TEST(ReadSurface, GlbWithChunksThatAreNotFilledUp) {
  SKIP_WITHOUT_ASSIMP();
  std::string json = gltf_text(box());
  const std::string binary = box_bytes([](std::string& out, const std::string& rows) { out += rows; });
  const std::size_t uri = json.find(",\"uri\"");
  json.erase(uri, json.find("\"}]", uri) + 1 - uri);
  const auto word = [](std::size_t number) {
    const auto own = static_cast<std::uint32_t>(number);
    return std::string(reinterpret_cast<const char*>(&own), 4);
  };
  for (int spaces = 0; spaces < 4; ++spaces, json += ' ') {
    for (const std::size_t filled : {std::size_t{0}, (4 - json.size() % 4) % 4}) {
      const std::string chunks = word(json.size()) + "JSON" + json + std::string(filled, ' ') +
                                 word(binary.size() + 1) + std::string("BIN\0", 4) + binary + '\0';
      expect_box("box.glb", "glTF" + word(2) + word(12 + chunks.size()) + chunks, 1.0);
    }
  }
}

TEST(ReadSurface, SaysWhatItMendedByFile) {
  SKIP_WITHOUT_ASSIMP();
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
  SKIP_WITHOUT_ASSIMP();
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
    EXPECT_TRUE(says(refusal, std::string(name) + ": "));
  }
}

}  // namespace
}  // namespace phymul::test
