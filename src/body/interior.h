// SPDX-License-Identifier: MIT
//
// What the filling asks of a shape, whatever describes it.
#pragma once

#include <phymul/types.h>

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

}  // namespace phymul
