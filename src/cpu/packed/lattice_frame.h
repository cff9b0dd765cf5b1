// SPDX-License-Identifier: MIT
//
// The lattice a body's particles stand on, and their order along it: tiles of lines, line by line, so that a run of
// particles is a brick whose lines are long enough for vectors.
#pragma once

#include <phymul/topology_textures.h>

#include <array>
#include <optional>
#include <vector>

namespace phymul::cpu {

class LatticeFrame {
 public:
  using Node = std::array<int, 3>;

  /// Of a body of which nearly all particles stand on the lattice of its first hexahedral cell, and fill it fairly;
  /// runs of `size` particles are to be bricks.
  static std::optional<LatticeFrame> of(const TopologyTextures& topology, Index size);

  std::optional<Node> node_of(const Vec3& rest) const;
  int tile_of(const Node& node) const;
  /// The axis of the lines, that along which they lie side by side in a tile, and the last.
  const std::array<int, 3>& axes() const { return axes_; }
  /// Old number of each new one; particles off the lattice come last.
  std::vector<Index> order(const VecList& rest) const;

 private:
  void cut_tiles(Index size);

  Vec3 low_ = Vec3::Zero(), h_ = Vec3::Ones();
  Node count_{};
  std::array<int, 3> axes_{0, 1, 2};
  int line_tiles_ = 1, side_tiles_ = 1;
};

}  // namespace phymul::cpu
