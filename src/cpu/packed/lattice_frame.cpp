// SPDX-License-Identifier: MIT
#include "lattice_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>
#include <tuple>

namespace phymul::cpu {
namespace {

/// Lattice places are rounded in double.
constexpr double equal = 1e-7;
/// Particles that must stand on the lattice, and places of it that must be taken.
constexpr double least_on_lattice = 0.95, least_filled = 0.25;
/// Nodes of a line beyond which lines are cut: bricks would be all surface.
constexpr int longest_line = 48;

/// Shapes of cells beyond which a body is no lattice of equal cells; see hexahedra.cpp.
constexpr std::size_t most_stiffnesses = 32;

/// Whether cells differ so much that no kernel of lattices takes them.
bool is_patchwork(const TopologyTextures& t) {
  std::set<float> stiffnesses;  // rounded: they are computed
  for (const CellTexel& cell : t.cells) {
    stiffnesses.insert(static_cast<float>(cell.shape_stiffness));
    if (stiffnesses.size() > most_stiffnesses) return true;
  }
  return false;
}

std::optional<Vec3> cell_size(const TopologyTextures& t) {
  for (const CellTexel& cell : t.cells) {
    if (cell.vertex[7] == none) continue;
    Vec3 low = t.rest[cell.vertex[0]], high = low;
    for (const Index i : cell.vertex) {
      low = low.cwiseMin(t.rest[i]);
      high = high.cwiseMax(t.rest[i]);
    }
    const Vec3 h = high - low;
    return h.minCoeff() > 0.05 * h.maxCoeff() ? std::optional(h) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::optional<LatticeFrame> LatticeFrame::of(const TopologyTextures& t, Index size) {
  const std::optional<Vec3> h = t.dimension == 3 ? cell_size(t) : std::nullopt;
  if (!h || is_patchwork(t)) return std::nullopt;
  LatticeFrame frame;
  frame.h_ = *h;
  frame.low_ = t.rest.front();
  Vec3 high = frame.low_;
  for (const Vec3& x : t.rest) {
    frame.low_ = frame.low_.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  double places = 1.0;
  for (int a = 0; a < 3; ++a) {
    const double count = std::round((high[a] - frame.low_[a]) / frame.h_[a]) + 1.0;
    places *= count;
    if (places * least_filled > t.particle_count) return std::nullopt;
    frame.count_[a] = static_cast<int>(count);
  }
  const auto on = std::ranges::count_if(t.rest, [&](const Vec3& x) { return frame.node_of(x).has_value(); });
  if (static_cast<double>(on) < least_on_lattice * t.particle_count) return std::nullopt;
  frame.cut_tiles(size);
  return frame;
}

/// The tiles whose runs of `size` nodes touch the fewest lines beside their own.
void LatticeFrame::cut_tiles(Index size) {
  std::ranges::stable_sort(axes_, [&](int a, int b) { return count_[a] > count_[b]; });
  std::swap(axes_[1], axes_[2]);
  const int line = count_[axes_[0]], side = count_[axes_[1]];
  line_tiles_ = (line + longest_line - 1) / longest_line;
  const double lines = static_cast<double>(size) * line_tiles_ / line;
  double least = std::numeric_limits<double>::infinity();
  for (int tiles = 1; tiles <= side; ++tiles) {
    const double width = static_cast<double>(side) / tiles;
    const double touched = (tiles == 1 ? width : width + 2.0) * (lines / width + 3.0);
    if (touched < least) side_tiles_ = tiles;
    least = std::min(least, touched);
  }
}

std::optional<LatticeFrame::Node> LatticeFrame::node_of(const Vec3& rest) const {
  Node node{};
  for (int a = 0; a < 3; ++a) {
    const double at = (rest[a] - low_[a]) / h_[a], whole = std::round(at);
    if (std::abs(at - whole) > equal * count_[a]) return std::nullopt;
    node[a] = static_cast<int>(whole);
  }
  return node;
}

int LatticeFrame::tile_of(const Node& node) const {
  const auto part = [&](int axis, int tiles) {
    return static_cast<int>(std::int64_t{node[axis]} * tiles / count_[axis]);
  };
  return part(axes_[0], line_tiles_) * side_tiles_ + part(axes_[1], side_tiles_);
}

std::vector<Index> LatticeFrame::order(const VecList& rest) const {
  using Key = std::tuple<int, int, int, int>;
  std::vector<Key> keys;
  keys.reserve(rest.size());
  for (const Vec3& x : rest) {
    const std::optional<Node> node = node_of(x);
    keys.push_back(node ? Key{tile_of(*node), (*node)[axes_[2]], (*node)[axes_[1]], (*node)[axes_[0]]}
                        : Key{std::numeric_limits<int>::max(), 0, 0, 0});
  }
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](Index a, Index b) { return keys[a] < keys[b]; });
  return order;
}

}  // namespace phymul::cpu
