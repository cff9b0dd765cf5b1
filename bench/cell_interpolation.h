// SPDX-License-Identifier: MIT
//
// The displacement of a body between its particles: by the shape functions of the volume cell a point is in.
#pragma once

#include <phymul/model.h>

#include <array>
#include <span>
#include <vector>

namespace phymul::bench {

struct PlaceInCell {
  Index cell = -1;
  std::array<Index, 8> particle{};
  std::array<double, 8> weight{};  ///< sum 1; 0 beyond the cell's vertices
  int count = 0;
  double outside = 0.0;  ///< how far out of the cell, in cell sizes; > 0 where the body's facets cut a rounding off

  Vec3 interpolate(std::span<const Vec3> values) const;
};

/// Where each point is in the rest shape. A point outside the body goes to the cell it is least outside of, and is
/// extrapolated by its shape functions, not moved. Throws Error for a point more than half a cell outside.
std::vector<PlaceInCell> locate(const Model& model, std::span<const Vec3> points);

}  // namespace phymul::bench
