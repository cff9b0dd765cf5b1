// SPDX-License-Identifier: MIT
//
// What the filling asks of a shape, whatever describes it.
#pragma once

#include <phymul/body.h>
#include <phymul/types.h>

#include <algorithm>
#include <vector>

#include "lattice.h"

namespace phymul {

class Interior {
 public:
  virtual ~Interior() = default;
  /// [points] 1 inside the shape, 0 outside.
  virtual std::vector<char> inside(const CentredLattice& lattice) const = 0;
  virtual std::vector<char> inside(const VecList& places) const = 0;
  /// Where the line from a point inside to one outside leaves the shape first, as a share of the way.
  virtual double exit(const Vec3& in, const Vec3& out) const = 0;
};

/// Of a shape that says of each place whether it is inside.
class PlaceInterior : public Interior {
 public:
  std::vector<char> inside(const CentredLattice& lattice) const override;
  std::vector<char> inside(const VecList& places) const override;

 private:
  virtual bool contains(const Vec3& x) const = 0;
};

/// Its function, but outside its box positive whatever the function says. Not a number where the function is not.
inline double clipped_distance(const Solid& solid, const Vec3& x) {
  return std::max(solid.distance(x), (solid.low - x).cwiseMax(x - solid.high).maxCoeff());
}

/// Of a shape that a function describes. Keeps a reference.
class SolidInterior : public PlaceInterior {
 public:
  explicit SolidInterior(const Solid& solid) : solid_(solid) {}
  double exit(const Vec3& in, const Vec3& out) const override;
  /// m^3, of lines along x, 16 through each cube, or up to 64 times as many if the lattice is to be graded.
  double volume(const CentredLattice& lattice, bool is_graded) const;

 private:
  bool contains(const Vec3& x) const override { return at(x) < 0.0; }
  double at(const Vec3& x) const;  ///< throws Error where the function is not a number
  const Solid& solid_;
};

}  // namespace phymul
