// SPDX-License-Identifier: MIT
#include "locality_order.h"

#include <array>
#include <cmath>
#include <cstdint>

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
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!rest.empty()) low = high = rest.front();
  for (const Vec3& x : rest) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double extent = (high - low).maxCoeff();
  const double scale = extent > 0.0 ? 2097151.0 / extent : 0.0;
  std::vector<std::uint64_t> codes;
  codes.reserve(rest.size());
  for (const Vec3& x : rest) {
    const Vec3 cell = (x - low) * scale;
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

/// Per particle the number of its coordinate along an axis among all that there are, counted as one where they are less
/// than `equal` apart. Returns how many.
Index number_levels(const VecList& rest, int axis, double equal, std::vector<Index>& level) {
  std::vector<double> at;
  at.reserve(rest.size());
  for (const Vec3& x : rest) at.push_back(x[axis]);
  std::ranges::sort(at);
  std::size_t count = 0;
  for (std::size_t k = 0; k < at.size(); ++k) {
    if (k == 0 || at[k] - at[k - 1] > equal) at[count++] = at[k];
  }
  at.resize(count);
  level.reserve(rest.size());
  for (const Vec3& x : rest) {
    level.push_back(static_cast<Index>(std::ranges::upper_bound(at, x[axis]) - at.begin()) - 1);
  }
  return static_cast<Index>(count);
}

}  // namespace

std::vector<Index> line_order(const VecList& rest) {
  constexpr double least_line = 2.0;     // particles, on average
  constexpr double most_in_layer = 512;  // whose stresses and those of both layers beside them stay in near caches
  const auto particles = static_cast<double>(rest.size());
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!rest.empty()) low = high = rest.front();
  for (const Vec3& x : rest) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  std::array<std::vector<Index>, 3> level;
  std::array<Index, 3> levels{};
  for (int a = 0; a < 3; ++a) levels[a] = number_levels(rest, a, 1e-7 * (high - low).maxCoeff(), level[a]);
  std::array<int, 3> axes{0, 1, 2};  // along a line, across layers, across tiles
  std::ranges::stable_sort(axes, [&](int a, int b) { return levels[a] > levels[b]; });
  const auto [along, layers, across] = axes;
  if (static_cast<double>(levels[layers]) * levels[across] * least_line > particles) return {};
  const auto tiles = static_cast<std::int64_t>(std::ceil(particles / levels[layers] / most_in_layer));
  std::vector<std::array<Index, 4>> key;
  key.reserve(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const auto tile = static_cast<Index>(level[across][i] * tiles / levels[across]);
    key.push_back({tile, level[layers][i], level[across][i], level[along][i]});
  }
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](Index a, Index b) { return key[a] < key[b]; });
  return order;
}

}  // namespace phymul
