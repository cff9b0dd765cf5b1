// SPDX-License-Identifier: MIT
//
// DisplayLists: which particles a body's faces, edges and links join. Constant, whatever the body does. VisibleSkin:
// what a display shows in place of a body.
#pragma once

#include <phymul/model.h>
#include <phymul/skin.h>

#include <array>
#include <vector>

namespace phymul {

/// An edge of the surface, and the unit normals of the two faces that meet there at rest; the second is the opposite of
/// the first at an open edge, so that it counts as contour from everywhere.
struct SurfaceEdge {
  std::array<Index, 2> ends;
  std::array<Vec3, 2> normal;
};

struct DisplayLists {
  std::vector<std::array<Index, 4>> faces;  ///< counter-clockwise from outside; the last is -1 in a triangle
  std::vector<SurfaceEdge> edges;           ///< of the faces, each once
  std::vector<std::array<Index, 2>> links;  ///< pairs of neighbours, each once
};

/// Faces: those pressure acts on (surface.h); of a plane body, its triangles and quads.
DisplayLists display_lists(const Model& model);

struct VisibleSkin {
  Skin skin;
  Model surface;  ///< the skin's points at rest as particles, its triangles as cells
};

}  // namespace phymul
