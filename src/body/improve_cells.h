// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "stuffing.h"

namespace phymul {

/// Radians.
struct Angles {
  double smallest = std::numbers::pi, largest = 0.0;
};

inline std::array<Vec3, 4> corners_of(const Tetrahedron& cell, const VecList& place) {
  return {place[cell[0]], place[cell[1]], place[cell[2]], place[cell[3]]};
}

/// Of the six dihedral angles of a tetrahedron, wound either way.
inline Angles dihedral_angles(const std::array<Vec3, 4>& corner) {
  std::array<Vec3, 4> normal;  // of the face opposite each corner, outward
  for (int k = 0; k < 4; ++k) {
    const Vec3 &a = corner[(k + 1) % 4], &b = corner[(k + 2) % 4], &c = corner[(k + 3) % 4];
    normal[k] = (b - a).cross(c - a).normalized();
    if (normal[k].dot(corner[k] - a) > 0.0) normal[k] = -normal[k];
  }
  double least = 1.0, most = -1.0;  // cosines between normals
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      const double cosine = std::clamp(normal[i].dot(normal[j]), -1.0, 1.0);
      least = std::min(least, cosine);
      most = std::max(most, cosine);
    }
  }
  return {std::numbers::pi - std::acos(least), std::numbers::pi - std::acos(most)};
}

/// Moves particles of cells that have a dihedral angle below 15 or above 165 degrees, or are inverted, to where the
/// worst angle of their cells is better: those inside anywhere, those of the outer faces in the mean plane of these. By
/// search along axes and diagonals with ever shorter steps (L. A. Freitag, C. Ollivier-Gooch, "Tetrahedral mesh
/// improvement using swapping and smoothing", Int. J. Numer. Meth. Eng. 40, 1997, improve the smallest angle likewise,
/// by its gradient).
void improve_cells(Stuffing& body, const std::vector<std::array<Index, 3>>& outer_faces);

}  // namespace phymul
