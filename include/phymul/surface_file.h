// SPDX-License-Identifier: MIT
//
// Surfaces of triangles from files.
#pragma once

#include <phymul/body.h>

#include <string>

namespace phymul {

/// Reads .stl, .obj, .ply, .gltf or .glb, text or binary, and mends the surface as mend_surface() does; all meshes of
/// the file, where its scene puts them, make one surface. Polygons are cut from a corner that sees all of them; lines
/// and points are left out. The formats do not say their unit of length, but for glTF, which has metres. Throws Error
/// as mend_surface() does, for a file that cannot be read, is not whole or holds no triangles, for a polygon without
/// such a corner, and for glTF that requires an extension of its meshes, or if phymul was built without Assimp.
Surface read_surface(const std::string& path, double metres_per_unit = 1.0);

}  // namespace phymul
