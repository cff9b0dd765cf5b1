// SPDX-License-Identifier: MIT
#include "duplicates.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "cell_geometry.h"

namespace phymul {
namespace {

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
  return hash ^ (hash >> 29);
}

using GridCell = std::array<std::int64_t, 3>;

/// Buckets of a grid of cubes with sides of twice the tolerance: whatever lies within the tolerance of a point is in
/// one of the eight cubes round the grid corner nearest to it. Only points that repeat none are put in, so a cube never
/// holds more than a few, however many points coincide.
class PointGrid {
 public:
  PointGrid(const VecList& points, double tolerance)
      : points_(points),
        tolerance_(tolerance),
        mask_(std::bit_ceil(points.size() * 2) - 1),
        head_(mask_ + 1, -1),
        next_(points.size(), -1) {
    low_ = points.front();
    for (const Vec3& x : points) low_ = low_.cwiseMin(x);
  }

  /// The point put in before that `i` repeats, or -1; then puts `i` in if it repeats none.
  Index find_or_insert(Index i) {
    // A point may be as far away as numbers go; so far that one bound serves for all of them.
    const Vec3 place = ((points_[i] - low_) / (2.0 * tolerance_)).cwiseMin(0x1p62);
    GridCell own, corner;
    for (int a = 0; a < 3; ++a) {
      own[a] = static_cast<std::int64_t>(std::floor(place[a]));
      corner[a] = static_cast<std::int64_t>(std::floor(place[a] + 0.5)) - 1;
    }
    for (int c = 0; c < 8; ++c) {
      const GridCell cell{corner[0] + (c & 1), corner[1] + (c >> 1 & 1), corner[2] + (c >> 2)};
      for (Index j = head_[bucket(cell)]; j >= 0; j = next_[j]) {
        if ((points_[i] - points_[j]).norm() <= tolerance_) return j;
      }
    }
    Index& head = head_[bucket(own)];
    next_[i] = head;
    head = i;
    return -1;
  }

 private:
  std::size_t bucket(const GridCell& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t coordinate : cell) hash = mixed(hash, static_cast<std::uint64_t>(coordinate));
    return hash & mask_;
  }

  const VecList& points_;
  double tolerance_;
  Vec3 low_;
  std::size_t mask_;
  std::vector<Index> head_, next_;
};

}  // namespace

Repeats repeated_points(const VecList& points, double tolerance) {
  Repeats repeats;
  if (points.size() < 2) return repeats;
  if (!std::isfinite(tolerance)) return repeats;  // of points too far apart for a size that is a number
  if (!(tolerance > 0.0)) {
    // The body has no size: all its points are one.
    for (Index i = 1; i < static_cast<Index>(points.size()); ++i) repeats.emplace_back(i, 0);
    return repeats;
  }
  PointGrid grid(points, tolerance);
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i) {
    const Index original = grid.find_or_insert(i);
    if (original >= 0) repeats.emplace_back(i, original);
  }
  return repeats;
}

Repeats repeated_cells(const std::vector<Cell>& cells) {
  const auto sorted = [&](Index row) {
    std::array<Index, 8> key;
    key.fill(-1);
    std::copy(cells[row].particles.begin(), cells[row].particles.end(), key.begin());
    // By insertion: GCC 12 warns of an overrun inside std::sort of so short an array.
    for (auto last = key.begin(); last != key.end(); ++last)
      std::rotate(std::upper_bound(key.begin(), last, *last), last, last + 1);
    return key;
  };
  std::vector<std::pair<std::uint64_t, Index>> hashed;
  for (Index row = 0; row < static_cast<Index>(cells.size()); ++row) {
    if (cell_edges(cells[row].type).empty()) continue;
    std::uint64_t hash = static_cast<std::uint64_t>(cells[row].type) + 1;
    for (const Index particle : sorted(row)) hash = mixed(hash, static_cast<std::uint64_t>(particle));
    hashed.emplace_back(hash, row);
  }
  std::sort(hashed.begin(), hashed.end());
  Repeats repeats;
  for (std::size_t from = 0, to = 0; from < hashed.size(); from = to) {
    for (to = from + 1; to < hashed.size() && hashed[to].first == hashed[from].first; ++to) {
      const Index original = hashed[from].second, row = hashed[to].second;
      if (cells[original].type == cells[row].type && sorted(original) == sorted(row))
        repeats.emplace_back(row, original);
    }
  }
  std::sort(repeats.begin(), repeats.end());
  return repeats;
}

}  // namespace phymul
