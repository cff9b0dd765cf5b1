// SPDX-License-Identifier: MIT
//
// Thin walls: bodies of triangles in space whose material has a thickness (Law::walls). They need one layer of
// particles where cells that fill a wall need several. Capsules: walls on the surface of bodies of cells.
#pragma once

#include <phymul/body.h>

#include <limits>

namespace phymul {

struct WallOptions {
  /// m, > 0: wanted length of the sides of triangles. Infinite: the surface's own triangles.
  double spacing = std::numeric_limits<double>::infinity();
  /// Thickness included, > 0.
  Material material{};
};

/// A wall with this surface as its middle, open or closed. All triangles are divided into four until no side is longer
/// than 1.4 spacings: each side into two at its middle, so that the surface keeps its shape. Edges with one
/// triangle are free; at edges with more than two triangles the wall branches, and the angles between its parts stay as
/// stiff as these. Model::notes has those of the surface. Throws Error for a surface that is not valid and for options
/// out of range.
Model make_wall(const Surface& surface, const WallOptions& options);

/// Gives the surface of a body of volume cells a capsule: a wall of the outer faces whose centre at rest (mean of their
/// particles) `contains` accepts, on the particles of the body; empty: of all. Faces of four particles become two
/// triangles. Returns how many triangles it added. Throws Error if there is no such face, if one of them has a wall
/// already, and as set_material() does.
int add_capsule(Model& model, const Material& material, const Contains& contains = {});

/// Clamps the edges with one triangle whose middle `contains` accepts; empty: all. Not those of triangles that a cut
/// crosses, which stay as they are: clamp, then cut. The wall keeps the direction there that it has at rest, also in a
/// plane of symmetry. Where the edge is, its particles must be held by the scene; an edge whose particles alone are
/// held is a hinge. Adds a cell of type line for each, with the material of its triangle. Returns how many. Throws
/// Error if there is none.
int clamp_edges(Model& model, const Contains& contains);

}  // namespace phymul
