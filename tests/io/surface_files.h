// SPDX-License-Identifier: MIT
//
// The same box in every format of surfaces, byte by byte.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>

#include "body/body_shapes.h"

namespace phymul::test {

/// 30 x 20 x 10, as a file in millimetres has it: eight vertices, twelve triangles.
inline Surface box() {
  Surface surface = box_surface({0, 0, 0}, {30, 20, 10});
  mend_surface(surface);
  return surface;
}

inline std::string row_of(const Vec3& x) {
  std::ostringstream out;
  out << x.x() << ' ' << x.y() << ' ' << x.z() << '\n';
  return out.str();
}

inline std::string stl_text(const Surface& surface) {
  std::ostringstream out;
  out << "solid box\n";
  for (const auto& t : surface.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const Index p : t) out << "vertex " << row_of(surface.vertices[p]);
    out << "endloop\nendfacet\n";
  }
  out << "endsolid box\n";
  return out.str();
}

inline void append_float(std::string& bytes, double value) {
  const auto number = static_cast<float>(value);
  char own[4];
  std::memcpy(own, &number, 4);
  bytes.append(own, 4);
}

inline std::string stl_bytes(const Surface& surface) {
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

inline std::string obj_text(const Surface& surface) {
  std::ostringstream out;
  for (const Vec3& x : surface.vertices) out << "v " << row_of(x);
  for (const auto& [a, b, c] : surface.triangles) out << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
  return out.str();
}

inline std::string ply_text(const Surface& surface) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << surface.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << surface.triangles.size()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& x : surface.vertices) out << row_of(x);
  for (const auto& [a, b, c] : surface.triangles) out << "3 " << a << ' ' << b << ' ' << c << '\n';
  return out.str();
}

inline std::string base64(const std::string& bytes) {
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
inline std::string box_bytes(const Append& append) {
  std::string bytes;
  for (const Vec3& x : box().vertices) {
    for (const double value : x) append_float(bytes, value);
  }
  for (const auto& t : box().triangles) append(bytes, std::string(reinterpret_cast<const char*>(t.data()), 12));
  return bytes;
}

/// In metres by a node that scales it.
inline std::string gltf_text(const Surface& surface) {
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

/// Little-endian, as every number of a binary glTF file.
inline std::string word(std::size_t number) {
  const auto own = static_cast<std::uint32_t>(number);
  return std::string(reinterpret_cast<const char*>(&own), 4);
}

/// `json` and the box's bytes, with the bytes that fill up each.
inline std::string glb_of(const std::string& json, const std::string& after_json, const std::string& after_box) {
  const std::string binary = box_bytes([](std::string& out, const std::string& rows) { out += rows; });
  const std::string chunks = word(json.size()) + "JSON" + json + after_json + word(binary.size() + after_box.size()) +
                             std::string("BIN\0", 4) + binary + after_box;
  return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

/// gltf_text without the bytes in it.
inline std::string glb_json() {
  std::string json = gltf_text(box());
  const std::size_t uri = json.find(",\"uri\"");
  return json.erase(uri, json.find("\"}]", uri) + 1 - uri);
}

/// Binary, little-endian; the numbers' bytes the other way round where `swap`, which the head does not say.
inline std::string ply_bytes(bool swap = false) {
  std::string bytes = ply_text(box());
  bytes.resize(bytes.find("end_header\n") + 11);
  bytes.replace(bytes.find("ascii"), 5, "binary_little_endian");
  std::string data = box_bytes([](std::string& out, const std::string& rows) { out += '\3' + rows; });
  for (std::size_t at = 0; swap && at < data.size(); at += 4) {
    at += at >= 96 && (at - 96) % 13 == 0;  // eight places of 12 bytes, then triangles of 13
    std::reverse(data.begin() + static_cast<std::ptrdiff_t>(at), data.begin() + static_cast<std::ptrdiff_t>(at) + 4);
  }
  return bytes + data;
}

inline std::string with_line_ends(const std::string& text, const std::string& line_end) {
  std::string out;
  for (const char c : text) out += c == '\n' ? line_end : std::string(1, c);
  return out;
}

}  // namespace phymul::test
