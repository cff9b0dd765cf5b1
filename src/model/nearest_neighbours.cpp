// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/model.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "base/bounding_box.h"

namespace phymul {
namespace {

/// Distances that differ by less are the same: on a lattice the choice among equals would be rounding's.
constexpr double same = 1.0 + 1e-6;

int longest_axis(const VecList& rest) {
  int axis = 0;
  bounding_box(rest).sizes().maxCoeff(&axis);
  return axis;
}

}  // namespace

RaggedList nearest_neighbours(const VecList& rest, int count) {
  const auto particles = static_cast<Index>(rest.size());
  if (count < 1 || count >= particles) {
    throw Error("nearest_neighbours: expected 1 to " + std::to_string(particles - 1) + " neighbours of " +
                std::to_string(particles) + " particles, got " + std::to_string(count));
  }
  const auto at_infinity = std::ranges::find_if(rest, [](const Vec3& x) { return !x.allFinite(); });
  if (at_infinity != rest.end()) {
    throw Error("nearest_neighbours: expected finite places, got another one of particle " +
                std::to_string(at_infinity - rest.begin()));
  }
  // Outward from each particle in the order along one axis, until that distance alone is larger than the last one's.
  const int axis = longest_axis(rest);
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](Index a, Index b) { return std::pair(rest[a][axis], a) < std::pair(rest[b][axis], b); });
  std::vector<std::vector<Index>> rows(rest.size());
  std::vector<std::pair<double, Index>> near;  // by distance; the first `count` and those as near as the last of them
  const auto limit = [&] {
    const auto last = static_cast<std::size_t>(count) - 1;
    return near.size() <= last ? std::numeric_limits<double>::infinity() : same * near[last].first;
  };
  for (Index place = 0; place < particles; ++place) {
    const Index i = order[place];
    near.clear();
    const auto away = [&](Index at) {
      return at < 0 || at >= particles ? std::numeric_limits<double>::infinity()
                                       : std::abs(rest[order[at]][axis] - rest[i][axis]);
    };
    Index below = place - 1, above = place + 1;
    while (below >= 0 || above < particles) {
      // A distance may be infinite although both places are not.
      const Index at = above >= particles || (below >= 0 && away(below) < away(above)) ? below-- : above++;
      if (away(at) > limit()) break;
      const std::pair entry{(rest[order[at]] - rest[i]).norm(), order[at]};
      if (entry.first > limit()) continue;
      near.insert(std::ranges::upper_bound(near, entry), entry);
      while (near.back().first > limit()) near.pop_back();
    }
    for (const auto& [distance, j] : near) {
      rows[i].push_back(j);
      rows[j].push_back(i);
    }
  }
  RaggedList list;
  for (std::vector<Index>& row : rows) {
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    list.push_row(row.begin(), row.end());
  }
  return list;
}

}  // namespace phymul
