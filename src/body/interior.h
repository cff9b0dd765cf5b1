// SPDX-License-Identifier: MIT
//
// What the filling asks of a shape, whatever describes it.
#pragma once

#include <phymul/body.h>
#include <phymul/types.h>

#include <algorithm>
#include <optional>
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

/// Where a continuous function that is negative at 0 and positive at 1 is zero. Halves the way until its end is exact
/// to a millionth of it, faster where the function is smooth: the secant of the two ends, one of them weighed down
/// where the other moves twice in a row (the Illinois rule).
template <class Function>
double root_between(const Function& f) {
  double a = 0.0, b = 1.0, at_a = f(a), at_b = f(b);
  int moved = 0;
  for (int turn = 0; turn < 60 && b - a > 1e-6; ++turn) {
    double middle = turn % 4 == 3 ? 0.5 * (a + b) : (a * at_b - b * at_a) / (at_b - at_a);
    if (!(middle > a && middle < b)) middle = 0.5 * (a + b);
    const double value = f(middle);
    if (value == 0.0) return middle;
    if (value < 0.0) {
      a = middle;
      at_a = value;
      if (moved == -1) at_b *= 0.5;
      moved = -1;
    } else {
      b = middle;
      at_b = value;
      if (moved == 1) at_a *= 0.5;
      moved = 1;
    }
  }
  return 0.5 * (a + b);
}

}  // namespace phymul
