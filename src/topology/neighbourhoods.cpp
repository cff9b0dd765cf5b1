// SPDX-License-Identifier: MIT
#include "neighbourhoods.h"

#include <algorithm>
#include <array>

namespace phymul {
namespace {

/// Enumerated triples without a base cost time for nothing, but less than half of what a base from a table does.
constexpr double most_triples_a_base = 1.5;

std::int64_t triple_count(std::int64_t neighbours) {
  return neighbours * (neighbours - 1) * (neighbours - 2) / 6;
}

}  // namespace

Index triple_row(Index n, Index j, Index k, Index l) {
  const auto pairs = [](Index m) { return m * (m - 1) / 2; };
  return static_cast<Index>(triple_count(n) - triple_count(n - j)) + pairs(n - j - 1) - pairs(n - k) + (l - k - 1);
}

Triples triples_of(const TopologyTextures& t, Index i) {
  Triples triples;
  const IndexTexel& at = t.index[i];
  if (at.base_count == 0) return triples;
  const auto row = t.neighbours.begin() + at.first_neighbour;
  const auto count = static_cast<Index>(at.neighbour_count);
  triples.neighbour.assign(row, row + count);
  triples.alpha.assign(t.alpha.begin() + at.first_neighbour, t.alpha.begin() + at.first_neighbour + count);
  triples.base.assign(static_cast<std::size_t>(triple_count(count)), none);
  for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
    std::array<Index, 3> place{};
    for (int k = 0; k < 3; ++k) {
      place[k] = static_cast<Index>(std::find(row, row + count, t.bases[b].vertex[k]) - row);
    }
    std::ranges::sort(place);
    triples.base[triple_row(count, place[0], place[1], place[2])] = b;
  }
  return triples;
}

bool is_enumerable(const TopologyTextures& t, Index most) {
  const bool plain = t.dimension == 3 && t.options.reaction != Reaction::conservative;
  if (!plain || t.base_count == 0) return false;
  std::int64_t triples = 0;
  for (Index i = 0; i < t.particle_count; ++i) {
    const IndexTexel& at = t.index[i];
    if (at.base_count == 0) continue;
    if (at.neighbour_count > most) return false;
    triples += triple_count(at.neighbour_count);
    const auto row = t.neighbours.begin() + at.first_neighbour;
    for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
      const auto& vertex = t.bases[b].vertex;
      const bool among = std::ranges::all_of(
          vertex, [&](Index v) { return std::find(row, row + at.neighbour_count, v) != row + at.neighbour_count; });
      if (!among) return false;
    }
  }
  return static_cast<double>(triples) <= most_triples_a_base * t.base_count;
}

}  // namespace phymul
