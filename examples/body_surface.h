// SPDX-License-Identifier: MIT
//
// What of a body can be seen from outside.
#pragma once

#include <phymul/model.h>

#include <array>
#include <vector>

struct Face {
  std::vector<phymul::Index> corners;  ///< seen from outside in counter-clockwise order
};

/// An edge of the surface with the one or two faces that meet there; -1: none.
struct SurfaceEdge {
  std::array<phymul::Index, 2> ends;
  std::array<int, 2> faces{-1, -1};
};

struct BodySurface {
  std::vector<Face> faces;
  std::vector<SurfaceEdge> edges;
};

/// The faces that belong to one volume cell only; without volume cells all triangles and quads; without these no faces,
/// and the links between neighbours as edges.
BodySurface surface_of(const phymul::Model& model);

/// A body whose only cells are triangles, to be shown in place of another one.
phymul::Model triangle_body(phymul::VecList vertices, const std::vector<std::array<phymul::Index, 3>>& triangles);
