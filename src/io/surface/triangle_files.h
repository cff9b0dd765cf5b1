// SPDX-License-Identifier: MIT
//
// STL, OBJ and PLY, text and binary: vertices in the file's unit, polygons as fans of triangles. Files are not trusted:
// Error, with the line or byte, unless the file is whole and what should be a number is one.
#pragma once

#include <phymul/body.h>

#include <string>
#include <string_view>

namespace phymul {

Surface read_stl(const std::string& path, std::string_view bytes);
Surface read_obj(const std::string& path, std::string_view bytes);
Surface read_ply(const std::string& path, std::string_view bytes);

}  // namespace phymul
