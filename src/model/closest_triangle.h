// SPDX-License-Identifier: MIT
//
// The nearest point of a closed surface of triangles, and on which side of it a point lies.
#pragma once

#include <phymul/types.h>

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "base/box_tree.h"

namespace phymul {

using Triangle = std::array<Index, 3>;

/// Signed distances from triangles that form a closed surface, counter-clockwise seen from outside. The sign is that of
/// the normal at the nearest face, edge or corner, angle-weighted there (J. A. Baerentzen, H. Aanaes, "Signed distance
/// computation using the angle weighted pseudonormal", IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253).
class ClosestTriangle {
 public:
  /// Copies both. The surface must be closed (open_edge), and no triangle flat (flat_triangle).
  ClosestTriangle(std::span<const Vec3> place, std::span<const Triangle> triangles);
  double signed_distance(const Vec3& x) const;  ///< m, negative inside

 private:
  struct Nearest {
    double squared;
    Vec3 way;     // from the nearest point to x
    Vec3 normal;  // there, of any length
  };
  void visit(Index own, const Vec3& x, Nearest& nearest) const;
  void look_at(Index triangle, const Vec3& x, Nearest& nearest) const;

  VecList place_;
  std::vector<Triangle> triangle_;                // in the order of the tree's items
  VecList face_normal_;                           // [triangles] unit
  std::vector<std::array<Vec3, 3>> edge_normal_;  // [triangles] of edges k, k + 1
  VecList corner_normal_;                         // [places]
  BoxTree tree_;                                  // over the triangles' middles
  std::vector<Eigen::AlignedBox3d> boxes_;        // [nodes]
};

VecList middles_of(std::span<const Vec3> place, std::span<const Triangle> triangles);

/// An edge that two triangles do not share in opposite directions, as its two places; {-1, -1} where the surface is
/// closed.
std::array<Index, 2> open_edge(std::span<const Triangle> triangles);

/// The row of a triangle without area up to rounding, so that its normal says nothing; -1: there is none.
Index flat_triangle(std::span<const Vec3> place, std::span<const Triangle> triangles);

}  // namespace phymul
