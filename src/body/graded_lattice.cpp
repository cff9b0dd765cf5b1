// SPDX-License-Identifier: MIT
#include "graded_lattice.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/decimal.h"
#include "filling.h"

namespace phymul {
namespace {

std::array<int, 3> moved(std::array<int, 3> at, int axis, int by) {
  at[axis] += by;
  return at;
}

std::array<int, 3> halfway(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
}

}  // namespace

GradedLattice::GradedLattice(const CentredLattice& roots, const BodyOptions& options) : roots_(roots) {
  refine(options);
  balance();
}

GradedLattice::Key GradedLattice::node_key(const Triple& at, int level) const {
  return ((static_cast<Key>(at[2]) * (roots_.count[1] << level)) + at[1]) * (roots_.count[0] << level) + at[0];
}

GradedLattice::Key GradedLattice::point_key(const Triple& at) const {
  return ((static_cast<Key>(at[2]) * (units * roots_.count[1])) + at[1]) * (units * roots_.count[0]) + at[0];
}

bool GradedLattice::is_in(const Triple& at, int level) const {
  for (int k = 0; k < 3; ++k) {
    if (at[k] < 0 || at[k] >= (roots_.count[k] - 1) << level) return false;
  }
  return true;
}

bool GradedLattice::exists(const Triple& at, int level) const {
  return level == 0 || refined_[level - 1].contains(node_key({at[0] / 2, at[1] / 2, at[2] / 2}, level - 1));
}

bool GradedLattice::is_refined(const Triple& at, int level) const {
  return level < most_halvings && refined_[level].contains(node_key(at, level));
}

double GradedLattice::asked_in(const Leaf& leaf, const BodyOptions& options) const {
  const double edge = roots_.edge / (1 << leaf.level);
  double least = std::numeric_limits<double>::infinity();
  for (int place = 0; place < 27; ++place) {
    const Vec3 share(place % 3, place / 3 % 3, place / 9);
    const Vec3 x = roots_.origin + edge * (Vec3(leaf.at[0], leaf.at[1], leaf.at[2]) + 0.5 * share);
    const double asked = options.spacing_at(x);
    const double finest = options.spacing / (1 << most_halvings);
    if (!(asked >= (1.0 - 1e-9) * finest) || !std::isfinite(asked)) {
      refuse_body("expected BodyOptions::spacing_at to be finite and at least an eighth of the spacing of " +
                  length_text(options.spacing) + " m, got " + length_text(asked) + " m at " + place_text(x));
    }
    least = std::min(least, asked);
  }
  return least;
}

/// Calls f for each leaf below the roots, where divides(node) says which nodes are none. In an order that does not
/// depend on how sets are stored.
template <class Divides, class Function>
void GradedLattice::each_leaf(const Divides& divides, const Function& f) const {
  const auto visit = [&](const auto& self, const Leaf& node) -> void {
    if (!divides(node)) return f(node);
    for (int k = 0; k < 8; ++k) {
      self(self,
           {{2 * node.at[0] + (k & 1), 2 * node.at[1] + (k >> 1 & 1), 2 * node.at[2] + (k >> 2)}, node.level + 1});
    }
  };
  for (int k = 0; k + 1 < roots_.count[2]; ++k) {
    for (int j = 0; j + 1 < roots_.count[1]; ++j) {
      for (int i = 0; i + 1 < roots_.count[0]; ++i) visit(visit, {{i, j, k}, 0});
    }
  }
}

void GradedLattice::refine(const BodyOptions& options) {
  const double most = std::min(10.0 * options.most_particles, 0.1 * std::numeric_limits<Index>::max());
  double leaves = 0.0;
  const auto divides = [&](const Leaf& node) {
    const double spacing = options.spacing / (1 << node.level);
    if (node.level == most_halvings || asked_in(node, options) >= (1.0 - 1e-9) * spacing) return false;
    refined_[node.level].insert(node_key(node.at, node.level));
    return true;
  };
  each_leaf(divides, [&](const Leaf&) {
    if (++leaves <= most) return;
    refuse_body("the field BodyOptions::spacing_at needs more than " + length_text(most) +
                " leaves of an octree, for at most " + std::to_string(options.most_particles) +
                " particles (BodyOptions::most_particles); ask for a larger spacing, or check the unit of length");
  });
}

/// All that touches a refined node is no larger than it.
void GradedLattice::balance() {
  for (int level = most_halvings - 1; level > 0; --level) {
    const Key rows = roots_.count[0] << level, columns = roots_.count[1] << level;
    for (const Key key : refined_[level]) {
      const Triple at{static_cast<int>(key % rows), static_cast<int>(key / rows % columns),
                      static_cast<int>(key / rows / columns)};
      for (int side = 0; side < 27; ++side) {
        const Triple beside{at[0] + side % 3 - 1, at[1] + side / 3 % 3 - 1, at[2] + side / 9 - 1};
        if (!is_in(beside, level)) continue;
        refined_[level - 1].insert(node_key({beside[0] / 2, beside[1] / 2, beside[2] / 2}, level - 1));
      }
    }
  }
}

void GradedLattice::number_points() {
  const auto divides = [this](const Leaf& node) { return is_refined(node.at, node.level); };
  const auto number = [&](const Triple& at, double edge) {
    const auto [found, is_new] = point_.try_emplace(point_key(at), static_cast<Index>(at_.size()));
    if (is_new) {
      at_.push_back(at);
      leaf_edge_.push_back(edge);
    }
    double& least = leaf_edge_[found->second];
    least = std::min(least, edge);
  };
  each_leaf(divides, [&](const Leaf& leaf) {
    const int half = units >> (leaf.level + 1);
    const double edge = 1.0 / (1 << leaf.level);
    Triple low{};
    for (int k = 0; k < 3; ++k) low[k] = 2 * half * leaf.at[k];
    number({low[0] + half, low[1] + half, low[2] + half}, edge);
    for (int k = 0; k < 8; ++k) {
      number({low[0] + 2 * half * (k & 1), low[1] + 2 * half * (k >> 1 & 1), low[2] + 2 * half * (k >> 2)}, edge);
    }
  });
  shortest_edge_.assign(at_.size(), std::numeric_limits<double>::infinity());
  each_leaf(divides, [&](const Leaf& leaf) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) add_cells(leaf, axis, side);
    }
  });
}

double GradedLattice::length(Index a, Index b) const {
  const Triple &from = at_[a], &to = at_[b];
  return Vec3(to[0] - from[0], to[1] - from[1], to[2] - from[2]).norm() / units;
}

/// -1 where there is none.
Index GradedLattice::point_at(const Triple& at) const {
  const auto found = point_.find(point_key(at));
  return found == point_.end() ? -1 : found->second;
}

void GradedLattice::add_cell(Tetrahedron cell) {
  Mat3 sides;  // whole numbers, so that the sign of the volume is exact
  for (int k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) sides(axis, k) = at_[cell[k + 1]][axis] - at_[cell[0]][axis];
  }
  if (sides.determinant() < 0.0) std::swap(cell[2], cell[3]);
  for (int k = 0; k < 4; ++k) {
    for (int l = 0; l < k; ++l) {
      const double own = length(cell[k], cell[l]);
      for (const Index end : {cell[k], cell[l]}) shortest_edge_[end] = std::min(shortest_edge_[end], own);
    }
  }
  cells_.push_back(cell);
}

/// At one face of a leaf: those of its own side, and of both sides where the leaf across has the same size.
void GradedLattice::add_cells(const Leaf& leaf, int axis, int side) {
  const Triple across = moved(leaf.at, axis, side);
  if (!is_in(across, leaf.level)) return;
  const int edge = units >> leaf.level, u = (axis + 1) % 3, v = (axis + 2) % 3;
  Triple middle{};
  for (int k = 0; k < 3; ++k) middle[k] = edge * leaf.at[k] + edge / 2;
  const Index own = point_at(middle);
  std::array<Triple, 4> square;  // around the face
  for (int k = 0; k < 4; ++k) {
    square[k] = moved(middle, axis, side * edge / 2);
    square[k][u] += (k == 1 || k == 2 ? edge : -edge) / 2;
    square[k][v] += (k >= 2 ? edge : -edge) / 2;
  }
  if (!exists(across, leaf.level)) {
    // The corner in the middle of the larger leaf's face.
    int first = 0;
    while (square[first][u] / edge % 2 == 0 || square[first][v] / edge % 2 == 0) ++first;
    std::array<Index, 4> p{};
    for (int k = 0; k < 4; ++k) p[k] = point_at(square[(first + k) % 4]);
    add_cell({own, p[0], p[1], p[2]});
    add_cell({own, p[0], p[2], p[3]});
    return;
  }
  const bool is_finer = is_refined(across, leaf.level);
  if (!is_finer && side < 0) return;  // made from across
  const Index other = point_at(moved(middle, axis, is_finer ? side * edge / 2 : side * edge));
  for (int k = 0; k < 4; ++k) {
    const Triple &from = square[k], &to = square[(k + 1) % 4];
    const Index a = point_at(from), b = point_at(to), between = point_at(halfway(from, to));
    if (between < 0) {
      add_cell({own, other, a, b});
    } else {
      add_cell({own, other, a, between});
      add_cell({own, other, between, b});
    }
  }
}

}  // namespace phymul
