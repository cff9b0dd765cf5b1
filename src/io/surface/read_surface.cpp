// SPDX-License-Identifier: MIT
#include <phymul/surface_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/byte_source.h"
#include "base/decimal.h"
#include "base/file_ending.h"
#include "base/file_error.h"

#ifdef PHYMUL_HAS_ASSIMP
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#endif

namespace phymul {
namespace {

#ifdef PHYMUL_HAS_ASSIMP

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

Surface read_triangles(const std::string& path) {
  Assimp::Importer importer;
  // None of its later treatments: they stop the program where they meet what they do not expect.
  const aiScene* scene = importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode) {
    fail_format(path, 0,
                std::string("the file cannot be read as ") + file_ending(path) + " (" + importer.GetErrorString() +
                    "); save it anew from the program that made it");
  }
  Surface surface;
  add_node(*scene, *scene->mRootNode, {}, surface);
  return surface;
}

#else

[[noreturn]] Surface read_triangles(const std::string& path) {
  throw Error(ErrorCode::not_supported,
              path +
                  ": phymul was built without Assimp, which reads surfaces; install it (Debian: libassimp-dev) and "
                  "build phymul again, or fill a Surface from a reader of your own",
              path);
}

#endif

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
    Surface surface = read_triangles(path);
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
