// SPDX-License-Identifier: MIT
//
// A part of a surface by points, for Scene::hold().
#pragma once

#include <phymul/body.h>

#include <vector>

namespace phymul {

/// Each point stands for a piece of the surface around it.
struct SurfacePatch {
  VecList points;             ///< [P] m, in the frame of Model::rest
  std::vector<double> areas;  ///< [P] m^2, > 0
};

/// The part of a surface whose places `inside` accepts. Pieces smaller than `spacing` are merged, larger ones are cut,
/// so that the points are about that far apart: take a third of the body's spacing. A triangle gets at most 1,000 in
/// one direction. The surface that the body was made from is better than the surface of its cells, which rounds off
/// edges. Throws Error for a spacing that is not above 0 and finite or is below 1e-15 of the distance from the origin,
/// for triangles with an index out of range, and if no part is inside.
SurfacePatch sample_surface(const Surface& surface, double spacing, const Contains& inside);

}  // namespace phymul
