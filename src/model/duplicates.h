// SPDX-License-Identifier: MIT
//
// Things that stand twice in a model, found in near-linear time.
#pragma once

#include <phymul/model.h>

#include <utility>
#include <vector>

namespace phymul {

/// A row and the lowest-numbered row that it repeats; ordered by the first.
using Repeats = std::vector<std::pair<Index, Index>>;

/// Particles no further than `tolerance` (m) from an earlier one that repeats none itself.
Repeats repeated_points(const VecList& points, double tolerance);

/// Cells of the same type over the same set of particles, in whatever order; poly_line, poly_vertex and atom cells are
/// mere lists and never count.
Repeats repeated_cells(const std::vector<Cell>& cells);

}  // namespace phymul
