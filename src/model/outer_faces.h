// SPDX-License-Identifier: MIT
//
// The faces of volume cells (in 2-D: edges of triangles and quads) that no other cell has.
#pragma once

#include <phymul/model.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "cell_geometry.h"

namespace phymul {

struct OuterFace {
  const Cell* cell = nullptr;
  std::array<Index, 4> ring{};  ///< in order, outward in a rightly wound cell; -1 at the end where there are fewer
};

/// The particles of a face, sorted, those that there are not first: compared as numbers.
struct FaceKey {
  std::uint64_t high = 0, low = 0;

  explicit FaceKey(std::array<Index, 4> of) {
    const auto order = [&](std::size_t a, std::size_t b) {
      if (of[b] < of[a]) std::swap(of[a], of[b]);
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
    const auto pair = [&](std::size_t k) {
      return std::uint64_t{static_cast<std::uint32_t>(of[k] + 1)} << 32 | static_cast<std::uint32_t>(of[k + 1] + 1);
    };
    high = pair(0);
    low = pair(2);
    least = of[0] >= 0 ? of[0] : of[1] >= 0 ? of[1] : of[2];
    four = of[0] >= 0;
  }
  Index least = -1;
  bool four = false;
  bool operator==(const FaceKey& other) const { return high == other.high && low == other.low; }
  bool operator<(const FaceKey& other) const { return high != other.high ? high < other.high : low < other.low; }
};

/// Calls visit(std::span<const OuterFace>) for each face all of whose particles are chosen(particle), once: in order of
/// their sorted particles, those of fewer particles first, and then of cells. Where a cut ends inside the body both
/// parts of a cell have the same face, and the span has both.
template <class Chosen, class Visit>
void each_outer_face(const Model& model, Chosen chosen, Visit visit) {
  struct Entry {
    FaceKey key;
    OuterFace face;
  };
  // Counted by their first particle, so that only what shares it is sorted.
  const std::size_t count = model.rest.size();
  const auto bin = [&](const FaceKey& key) { return (key.four ? count : 0) + static_cast<std::size_t>(key.least); };
  std::vector<Entry> entries;
  entries.reserve(4 * model.cells.size());
  std::vector<Index> end(2 * count + 1, 0);
  for (const Cell& cell : model.cells) {
    if (!is_solid(model.dimension, cell)) continue;
    each_face(model.dimension, cell, [&](const std::array<Index, 4>& ring) {
      if (!std::ranges::all_of(ring, [&](Index i) { return i < 0 || chosen(i); })) return;
      entries.push_back({FaceKey(ring), {&cell, ring}});
      ++end[bin(entries.back().key) + 1];
    });
  }
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Index> rows(entries.size()), at(end.begin(), end.end() - 1);  // of entries
  for (std::size_t row = 0; row < entries.size(); ++row) rows[at[bin(entries[row].key)]++] = static_cast<Index>(row);
  std::vector<OuterFace> faces;
  for (std::size_t b = 0; b + 1 < end.size(); ++b) {
    const auto in_bin = std::span(rows).subspan(end[b], end[b + 1] - end[b]);
    std::ranges::sort(in_bin, [&](Index one, Index other) {
      const FaceKey &a = entries[one].key, &c = entries[other].key;
      return a == c ? one < other : a < c;
    });
    for (std::size_t from = 0, to = 0; from < in_bin.size(); from = to) {
      const Entry& first = entries[in_bin[from]];
      for (to = from + 1; to < in_bin.size() && entries[in_bin[to]].key == first.key;) ++to;
      const auto group = in_bin.subspan(from, to - from);
      const auto of_one_cell = [&](Index row) {
        return cell_centre(*entries[row].face.cell, model.rest) == cell_centre(*first.face.cell, model.rest);
      };
      if (group.size() > 1 && (first.face.cell->cuts.empty() || !std::ranges::all_of(group, of_one_cell))) continue;
      faces.clear();
      for (const Index row : group) faces.push_back(entries[row].face);
      visit(std::span<const OuterFace>(faces));
    }
  }
}

}  // namespace phymul
