// SPDX-License-Identifier: MIT
#include "locality_order.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "base/box_tree.h"

namespace phymul {
namespace {

/// The low 21 bits of v, two zero bits between each.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

std::vector<std::uint64_t> morton_codes(const VecList& rest) {
  const Eigen::AlignedBox3d box = bounding_box(rest);
  const double extent = box.sizes().maxCoeff();
  const double scale = extent > 0.0 ? 2097151.0 / extent : 0.0;
  std::vector<std::uint64_t> codes;
  codes.reserve(rest.size());
  for (const Vec3& x : rest) {
    const Vec3 cell = (x - box.min()) * scale;
    codes.push_back(spread(static_cast<std::uint64_t>(cell.x())) | spread(static_cast<std::uint64_t>(cell.y())) << 1 |
                    spread(static_cast<std::uint64_t>(cell.z())) << 2);
  }
  return codes;
}

}  // namespace

void sort_windows(std::vector<Index>& order, const std::vector<Index>& work, Index window) {
  for (auto first = order.begin(); first != order.end();) {
    const auto last = first + std::min<std::ptrdiff_t>(window, order.end() - first);
    std::stable_sort(first, last, [&](Index a, Index b) { return work[a] > work[b]; });
    first = last;
  }
}

std::vector<Index> locality_order(const VecList& rest, const std::vector<Index>& work, Index window) {
  const std::vector<std::uint64_t> codes = morton_codes(rest);
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return codes[a] < codes[b]; });
  sort_windows(order, work, window);
  return order;
}

namespace {

/// Coordinates along an axis at which several particles stand, in order.
std::vector<double> levels_of(const VecList& rest, int axis, double equal) {
  constexpr std::size_t several = 3;
  std::vector<double> all;
  all.reserve(rest.size());
  for (const Vec3& x : rest) all.push_back(x[axis]);
  std::ranges::sort(all);
  std::vector<double> levels;
  for (std::size_t first = 0, k = 1; k <= all.size(); ++k) {
    if (k < all.size() && all[k] - all[k - 1] <= equal) continue;
    if (k - first >= several) levels.push_back(all[first]);
    first = k;
  }
  return levels;
}

/// The number of the nearest one.
Index nearest(const std::vector<double>& levels, double x) {
  const auto above = std::ranges::lower_bound(levels, x);
  const auto k = static_cast<Index>(above - levels.begin());
  const bool below = above == levels.end() || (k > 0 && x - levels[k - 1] < *above - x);
  return below ? k - 1 : k;
}

}  // namespace

std::vector<Index> line_order(const VecList& rest) {
  constexpr double least_line = 2.0;     // particles, on average
  constexpr double most_in_layer = 512;  // whose stresses and those of both layers beside them stay in near caches
  const auto particles = static_cast<double>(rest.size());
  const double equal = 1e-7 * bounding_box(rest).sizes().maxCoeff();
  const std::array<std::vector<double>, 3> levels{levels_of(rest, 0, equal), levels_of(rest, 1, equal),
                                                  levels_of(rest, 2, equal)};
  std::array<int, 3> axes{0, 1, 2};
  std::ranges::stable_sort(axes, [&](int a, int b) { return levels[a].size() > levels[b].size(); });
  const int along = axes[0];
  const std::vector<double>&layers = levels[axes[1]], &across = levels[axes[2]];
  const auto lines = static_cast<double>(layers.size() * across.size());
  if (lines == 0.0 || lines * least_line > particles) return {};
  const auto tiles =
      static_cast<std::int64_t>(std::ceil(particles / static_cast<double>(layers.size()) / most_in_layer));
  using Key = std::tuple<std::int64_t, Index, Index, double>;
  std::vector<Key> key;
  key.reserve(rest.size());
  for (const Vec3& x : rest) {
    const Index layer = nearest(layers, x[axes[1]]), line = nearest(across, x[axes[2]]);
    key.emplace_back(line * tiles / static_cast<std::int64_t>(across.size()), layer, line, x[along]);
  }
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](Index a, Index b) { return key[a] < key[b]; });
  return order;
}

}  // namespace phymul
