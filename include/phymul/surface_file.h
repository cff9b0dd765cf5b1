// SPDX-License-Identifier: MIT
//
// Surfaces of triangles from files.
#pragma once

#include <phymul/body.h>

#include <string>

namespace phymul {

/// Reads .stl, .obj, .ply, .gltf or .glb, text or binary, and mends the surface as mend_surface() does; all meshes of
/// the file, where its scene puts them, make one surface. Polygons are cut from their first corner; lines and points
/// are left out. The formats do not say their unit of length, but for glTF, which has metres. Throws Error as
/// mend_surface() does, for a file that cannot be read, is not whole or holds no triangles, and for glTF if phymul was
/// built without Assimp.
Surface read_surface(const std::string& path, double metres_per_unit = 1.0);

}  // namespace phymul
