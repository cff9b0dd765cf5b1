// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/body.h>

#include <optional>

#include "interior.h"

namespace phymul {

/// Where a line along x passes a triangle.
struct Passage {
  double x;   ///< m
  int enter;  ///< 1: into what the triangle bounds; -1: out of it
};

/// Of the line at (y, z); none if it misses the triangle. On which side the line passes an edge is computed in the same
/// way for all triangles of the edge, so that no line slips between two of them or meets both: rounding moves x, but a
/// line comes out of a closed surface as often as it goes in.
std::optional<Passage> passage(const VecList& vertices, const std::array<Index, 3>& triangle, double y, double z);

/// Of a mended surface. Keeps references to it and to the lattice.
///
/// Inside is where a line along x has gone in through the surface more often than out. More than once is where shells
/// overlap, which find_crossing() does not see if they do so along common faces only: refused, because the surface's
/// volume counts it twice.
class SurfaceInterior : public Interior {
 public:
  SurfaceInterior(const Surface& surface, const CentredLattice& lattice);
  /// Throws Error where the surface overlaps itself.
  std::vector<char> inside(const CentredLattice& lattice) const override;
  std::vector<char> inside(const VecList& places) const override;
  double exit(const Vec3& in, const Vec3& out) const override;

 private:
  std::array<int, 3> cube_at(const Vec3& x) const;
  std::size_t row_of(int i, int j, int k) const;
  void sort_into_cubes();

  const Surface& surface_;
  const CentredLattice& lattice_;
  std::vector<Index> of_cube_;    // [cubes + 1] first of each cube in triangles_
  std::vector<Index> triangles_;  // that reach into each cube of the lattice
};

}  // namespace phymul
