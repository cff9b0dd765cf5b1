// SPDX-License-Identifier: MIT
//
// Orders of particles and terms for locality: who gathers neighbours from memory runs up to four times faster when they
// lie near each other, and lanes idle less when particles side by side have as much to do.
#pragma once

#include <phymul/topology_textures.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

namespace phymul {

/// Particles along a Morton curve through the rest shape; within windows of `window` of them by decreasing `work` (a
/// count per particle), ties in curve order. Result: old number of each new one, shape [N].
std::vector<Index> locality_order(const VecList& rest, const std::vector<Index>& work, Index window);

/// Particles of a lattice line after line, along its longest axis, lines layer after layer, in tiles of a few hundred
/// particles per layer. Particles off the lattice stand with the nearest line. Empty for a body without such lines.
std::vector<Index> line_order(const VecList& rest);

/// Sorts each `window` particles of an order by decreasing `work`, ties as they stood.
void sort_windows(std::vector<Index>& order, const std::vector<Index>& work, Index window);

/// Terms by the least of their vertices, vertex(row, corner) other than `none`; ties as they stood. Result: old row of
/// each new one.
template <class Vertex>
std::vector<Index> order_by_least_vertex(Index rows, Index corners, const Vertex& vertex) {
  std::vector<Index> least(static_cast<std::size_t>(rows), std::numeric_limits<Index>::max());
  for (Index row = 0; row < rows; ++row) {
    for (Index corner = 0; corner < corners; ++corner) {
      const Index v = vertex(row, corner);
      if (v != none) least[row] = std::min(least[row], v);
    }
  }
  std::vector<Index> order(least.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return least[a] < least[b]; });
  return order;
}

}  // namespace phymul
