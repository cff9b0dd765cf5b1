// SPDX-License-Identifier: MIT
//
// From a shape to a model: the lattice over its box, the filling, and what is reported about it.
#pragma once

#include <phymul/body.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "interior.h"
#include "stuffing.h"

namespace phymul {

/// Throws Error "make_body: <what>".
[[noreturn]] void refuse_body(const std::string& what);

/// Over the box and a cube around it, with the box in the middle. Throws Error for options out of range.
CentredLattice lattice_over(const Vec3& low, const Vec3& high, const BodyOptions& options);

/// m^3, of a shape; whether its lattice is graded says how exactly it has to be measured.
using WantedVolumeOf = std::function<double(bool is_graded)>;

/// The points inside of the lattice, graded as options.spacing_at asks, as a model whose surface is moved to meet the
/// volume. `adjust` may change what is filled. Throws Error as make_body() does, but not for the volume.
Model filled_body(const Interior& interior, const CentredLattice& lattice, const WantedVolumeOf& volume_of,
                  const BodyOptions& options, BodyReport& report, const std::function<void(Stuffing&)>& adjust = {});

/// Throws Error for an error of the volume above options.most_volume_error. `thin` says what is lost of the shape;
/// empty text: nothing, so that edges and corners are the cause; without the function both may be.
void require_volume(const BodyReport& report, const BodyOptions& options, const std::function<std::string()>& thin);

/// Parts of a shape farther from its body than the spacing asked for there, by samples: `sample` calls its argument
/// with each. "0.012 m around (0, 0, 0.1) m": the diagonal and the middle of a part's box, the longest first, five at
/// most and the number of the others. Empty: none. `skin`: all particles, and the triangles of the body's surface.
std::string lost_parts(const std::function<void(const Contains&)>& sample, const Surface& skin,
                       const BodyOptions& options);

/// A note, if the body's surface has another number of shells, another Euler number (V - E + F) or more edges of more
/// than two faces than the surface; else empty.
std::string fused_note(const Surface& surface, const Surface& skin);

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
