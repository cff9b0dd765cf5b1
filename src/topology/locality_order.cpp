// SPDX-License-Identifier: MIT
#include "locality_order.h"

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

}  // namespace phymul
