// SPDX-License-Identifier: MIT
#include <phymul/surface_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/files.h"
#include "triangle_files.h"

#ifdef PHYMUL_HAS_ASSIMP
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace phymul {
namespace {

constexpr std::size_t most_bytes = std::size_t{4} << 30;

#ifdef PHYMUL_HAS_ASSIMP

std::string word_of(std::size_t number) {  // little-endian
  std::string word;
  for (int k = 0; k < 4; ++k) word += static_cast<char>(number >> 8 * k & 255);
  return word;
}

/// The file's bytes, with chunks of a length that is no multiple of 4 filled up as the format requires. Assimp takes as
/// much memory as a chunk says it is long, and keeps some of it where the chunk is not there; so lengths are held here.
std::string mended_glb(const std::string& path) {
  const std::string bytes = read_whole_file(path, most_bytes);
  if (!bytes.starts_with("glTF" + word_of(2))) {
    fail_format(path, 0, "expected binary glTF of version 2, which begins with \"glTF\" and the number 2");
  }
  std::string chunks;
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    std::size_t length = 0;
    for (int k = 4; k-- > 0;) length = length << 8 | static_cast<unsigned char>(bytes[at + k]);
    if (length > bytes.size() - at - 8) {
      fail_format(path, 0,
                  "the chunk at byte " + std::to_string(at) + " says that it has " + std::to_string(length) +
                      " bytes, but the file ends after " + std::to_string(bytes.size() - at - 8) +
                      "; it was cut short or damaged");
    }
    const std::string kind = bytes.substr(at + 4, 4), filling((4 - length % 4) % 4, kind == "JSON" ? ' ' : '\0');
    if (at == 12 && kind != "JSON") fail_format(path, 0, "expected a chunk \"JSON\" at byte 12");
    chunks += word_of(length + filling.size()) + kind + bytes.substr(at + 8, length) + filling;
    at += 8 + length;
    // Some fill up and do not count it: the next chunk is where one begins.
    if (bytes.compare(at + 4 <= bytes.size() ? at + 4 : at, 3, "BIN") != 0) at += filling.size();
  }
  return "glTF" + word_of(2) + word_of(12 + chunks.size()) + chunks;
}

/// Assimp passes over extensions that it does not know, and reads places as if these were not there. What it cannot
/// read of Draco it refuses.
void require_extensions(const std::string& path, std::string_view json) {
  const std::size_t begin = json.find("\"extensionsRequired\"");
  if (begin == json.npos) return;
  std::string_view names = json.substr(begin + 20);
  names = names.substr(0, names.find(']'));
  for (std::size_t open = names.find('"'); open != names.npos; open = names.find('"')) {
    names.remove_prefix(open + 1);
    const std::string name(names.substr(0, names.find('"')));
    names.remove_prefix(std::min(name.size() + 1, names.size()));
    const auto has = [&](const char* part) { return name.find(part) != name.npos; };
    if (has("_materials_") || has("_texture_") || has("_lights_") || name == "KHR_draco_mesh_compression") continue;
    fail_format(path, 0, "it needs the glTF extension " + cited(name) + ", which is not read; export it without");
  }
}

/// Adds the meshes of a node and of those below it.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& around, Surface& surface) {
  const aiMatrix4x4 place = around * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    const auto first = static_cast<Index>(surface.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D x = place * mesh.mVertices[v];
      surface.vertices.emplace_back(x.x, x.y, x.z);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      for (unsigned k = 2; k < face.mNumIndices; ++k) {
        std::array<Index, 3> triangle{};
        std::ranges::transform(std::array{0u, k - 1, k}, triangle.begin(),
                               [&](unsigned corner) { return first + static_cast<Index>(face.mIndices[corner]); });
        surface.triangles.push_back(triangle);
      }
    }
  }
  for (unsigned child = 0; child < node.mNumChildren; ++child) add_node(scene, *node.mChildren[child], place, surface);
}

Surface read_gltf(const std::string& path) {
  Assimp::Importer importer;
  // None of its later treatments: they stop the program where they meet what they do not expect.
  const std::string ending = file_ending(path);
  const std::string bytes = ending == ".glb" ? mended_glb(path) : read_whole_file(path, most_bytes);
  require_extensions(path, bytes);
  const aiScene* scene =
      ending == ".glb" ? importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, "glb") : importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode) {
    fail_format(path, 0,
                "the file cannot be read as " + ending + " (" + importer.GetErrorString() +
                    "); save it anew from the program that made it");
  }
  Surface surface;
  add_node(*scene, *scene->mRootNode, {}, surface);
  return surface;
}

#else

[[noreturn]] Surface read_gltf(const std::string& path) {
  throw Error(ErrorCode::not_supported,
              path +
                  ": phymul was built without Assimp, which reads glTF; install it (Debian: libassimp-dev) and "
                  "build phymul again, or export the surface as .stl, .obj or .ply",
              path);
}

#endif

Surface read_triangles(const std::string& path, std::string_view ending) {
  if (ending == ".stl") return read_stl(path, read_whole_file(path, most_bytes));
  if (ending == ".obj") return read_obj(path, read_whole_file(path, most_bytes));
  if (ending == ".ply") return read_ply(path, read_whole_file(path, most_bytes));
  return read_gltf(path);
}

}  // namespace

Surface read_surface(const std::string& path, double metres_per_unit) {
  if (!(metres_per_unit > 0.0) || !std::isfinite(metres_per_unit)) {
    throw Error("read_surface: expected metres_per_unit above 0, got " + to_decimal(metres_per_unit));
  }
  constexpr std::array<std::string_view, 5> known{".stl", ".obj", ".ply", ".gltf", ".glb"};
  const std::string extension = file_ending(path);
  if (std::ranges::find(known, extension) == known.end()) {
    fail_format(path, 0, "expected a surface in a .stl, .obj, .ply, .gltf or .glb file, got \"" + extension + "\"");
  }
  open_file(path);  // or a reason is told
  try {
    Surface surface = read_triangles(path, extension);
    for (Vec3& x : surface.vertices) x *= metres_per_unit;
    mend_surface(surface);
    for (std::string& note : surface.notes) note = path + ": " + note;
    return surface;
  } catch (const std::bad_alloc&) {
    fail_memory(path);
  } catch (const Error& error) {
    if (!error.file().empty()) throw;
    throw Error(ErrorCode::file_format, path + ": " + error.what(), path);
  }
}

}  // namespace phymul
