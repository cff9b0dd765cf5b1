// SPDX-License-Identifier: MIT
#include "grid_shape.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/bounding_box.h"

namespace phymul {

GridShape GridShape::over(std::span<const Vec3> points, double spacing) {
  const Eigen::AlignedBox3d box = bounding_box(points);
  // Tables are of the whole box: one much larger than what is in it gets larger cells.
  const double most = std::min(1e9, 1e6 + 64.0 * static_cast<double>(points.size()));
  while (((box.sizes() / spacing).array() + 2.0).prod() > most) spacing *= 1.25;
  GridShape shape{.origin = box.min()};
  for (int axis = 0; axis < 3; ++axis) {
    const double size = box.sizes()[axis];
    shape.cells[axis] = std::max(1, static_cast<Index>(std::lround(size / spacing)));
    shape.spacing[axis] = size > 0.0 ? size / shape.cells[axis] : spacing;
  }
  std::ranges::stable_sort(shape.slow_to_fast, std::greater(), [&](int axis) { return shape.cells[axis]; });
  return shape;
}

GridShape GridShape::coarser() const {
  GridShape shape{.origin = origin, .spacing = 2.0 * spacing, .slow_to_fast = slow_to_fast};
  for (int axis = 0; axis < 3; ++axis) shape.cells[axis] = (cells[axis] + 1) / 2;
  return shape;
}

std::size_t GridShape::row_of(const std::array<Index, 3>& at, Index more) const {
  std::size_t row = 0;
  for (const int axis : slow_to_fast) row = row * static_cast<std::size_t>(cells[axis] + more) + at[axis];
  return row;
}

std::size_t GridShape::rows(Index more) const {
  std::size_t rows = 1;
  for (const Index count : cells) rows *= static_cast<std::size_t>(count + more);
  return rows;
}

}  // namespace phymul
