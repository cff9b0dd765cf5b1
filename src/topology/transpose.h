// SPDX-License-Identifier: MIT
//
// Transposed tables: for each particle, where it occurs.
#pragma once

#include <phymul/types.h>

namespace phymul {

/// Rows of the result list, for each of `particles` particles, the entries row * corners + corner with
/// vertex(row, corner) = that particle, in increasing order; corners whose vertex is negative are passed over.
/// Precondition: rows * corners fits an Index.
template <class Vertex>
RaggedList transpose(Index particles, Index rows, Index corners, const Vertex& vertex) {
  RaggedList list;
  list.offset.assign(static_cast<std::size_t>(particles) + 1, 0);
  for (Index row = 0; row < rows; ++row) {
    for (Index corner = 0; corner < corners; ++corner) {
      const Index v = vertex(row, corner);
      if (v >= 0) ++list.offset[v + 1];
    }
  }
  for (Index i = 0; i < particles; ++i) list.offset[i + 1] += list.offset[i];
  list.entry.resize(static_cast<std::size_t>(list.offset.back()));
  std::vector<Index> next(list.offset.begin(), list.offset.end() - 1);
  for (Index row = 0; row < rows; ++row) {
    for (Index corner = 0; corner < corners; ++corner) {
      const Index v = vertex(row, corner);
      if (v >= 0) list.entry[next[v]++] = row * corners + corner;
    }
  }
  return list;
}

}  // namespace phymul
