// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/body.h>

#include <optional>

namespace phymul {

struct SurfaceCrossing {
  std::array<Index, 2> triangles;
  Vec3 place;  ///< m, one point of both
};

/// Two triangles of which an edge of one passes through the other's inside; none if there are no such. Triangles that
/// touch, at a corner or along an edge that they share or not, do not cross.
std::optional<SurfaceCrossing> find_crossing(const Surface& surface);

}  // namespace phymul
