// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/body.h>

#include "interior.h"

namespace phymul {

/// Of a mended surface. Keeps references to it and to the lattice.
///
/// Inside is what a line along x from a point leaves through an odd number of triangles. Whether a line passes an edge
/// on one side or the other is computed in the same way for both triangles of the edge, so that no line slips between
/// them or meets both: rounding moves a crossing, but changes no parity.
class SurfaceInterior : public Interior {
 public:
  SurfaceInterior(const Surface& surface, const CentredLattice& lattice);
  std::vector<char> inside(const CentredLattice& lattice) const override;
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
