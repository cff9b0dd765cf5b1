// SPDX-License-Identifier: MIT
//
// The body-centred cubic lattice: corners and middles of cubes. Each point has 14 neighbours, 8 at sqrt(3)/2 of the
// cubes' edge (short) and 6 at the edge (long); they span equal tetrahedra, two points of either kind each.
#pragma once

#include <phymul/types.h>

#include <array>
#include <cstddef>

namespace phymul {

/// Points (i, j, k) with 0 <= i < count[0] and so on: a corner and the middle of the cube behind it, whose rows follow
/// each other.
struct CentredLattice {
  Vec3 origin = Vec3::Zero();  ///< m, of corner (0, 0, 0)
  double edge = 0.0;           ///< m, of the cubes
  std::array<int, 3> count{};  ///< corners along each axis; as many middles

  static constexpr double short_length = 0.86602540378443864676;  ///< in edges
  /// Mean distance to the 14 neighbours, in edges.
  static constexpr double mean_length = (8.0 * short_length + 6.0) / 14.0;

  std::size_t points() const { return 2 * static_cast<std::size_t>(count[0]) * count[1] * count[2]; }
  Index corner(int i, int j, int k) const { return 2 * ((k * count[1] + j) * count[0] + i); }
  Index middle(int i, int j, int k) const { return corner(i, j, k) + 1; }
  static bool is_middle(Index point) { return (point & 1) != 0; }

  Vec3 place(Index point) const {
    const Index cube = point / 2, row = cube / count[0];
    const double half = is_middle(point) ? 0.5 : 0.0;
    return origin + edge * Vec3(cube % count[0] + half, row % count[1] + half, row / count[1] + half);
  }

  /// Steps in row numbers to the neighbours of a corner (middle): the 8 short ones, then the 6 long ones. They are
  /// right for points with a cube on every side.
  std::array<Index, 14> steps(bool from_middle) const {
    const Index x = 2, y = 2 * count[0], z = 2 * count[0] * count[1];
    std::array<Index, 14> steps{};
    for (int k = 0; k < 8; ++k) {
      const Index cubes = (k & 1 ? x : 0) + (k & 2 ? y : 0) + (k & 4 ? z : 0);
      steps[k] = from_middle ? cubes - 1 : 1 - cubes;
    }
    const std::array<Index, 3> along{x, y, z};
    for (int k = 0; k < 3; ++k) {
      steps[8 + 2 * k] = along[k];
      steps[9 + 2 * k] = -along[k];
    }
    return steps;
  }
};

}  // namespace phymul
