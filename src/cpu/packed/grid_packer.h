// SPDX-License-Identifier: MIT
//
// Stars and boxes by the nodes of a lattice (simd::Grid), cluster by cluster.
#pragma once

#include <map>
#include <optional>

#include "box_lattice.h"
#include "cluster_slots.h"
#include "lattice_frame.h"

namespace phymul::cpu {

class GridPacker {
 public:
  /// Takes what stands in the order of the lattice out of `boxes`, if enough of it does.
  GridPacker(BoxLattice& boxes, const VecList& rest, const std::optional<LatticeFrame>& frame, Index size,
             std::size_t clusters, PackedBody& body);

  void pack(int c, Slots& slots);
  void fill_idle_lanes(int c, std::int32_t idle);
  void point(int c, simd::Job& job) const;
  double cost(const simd::Job& job) const;  ///< ns a step, rough

 private:
  /// A particle that a star or its box needs, and where it must stand.
  struct Member {
    Index particle;
    LatticeFrame::Node node;
  };
  /// `lanes` nodes from `node` on; a star each, or none.
  struct Row {
    std::int32_t node = 0;
    int shape = 0;
    std::vector<Index> star;
  };
  struct Plan {
    std::array<int, 3> stride{};  // by axis
    std::vector<Index> particle;  // [nodes], none where there is none
    std::vector<Row> rows;
  };
  /// What stands on the nodes of one tile, and where they begin.
  struct Piece {
    std::vector<Index> stars;
    LatticeFrame::Node low{}, high{};
    std::int32_t first = 0;
  };
  struct Start {
    std::size_t slot, row;
  };

  void find_boxes(const BoxLattice& boxes);
  std::vector<Member> members_of(const BoxLattice& boxes, Index star) const;
  std::map<int, Piece> pieces_of(const BoxLattice& boxes, const std::vector<Index>& stars) const;
  void plan(const BoxLattice& boxes, const std::vector<Index>& stars, Plan& to);
  bool enter(const BoxLattice& boxes, Index star, const Piece& piece, Plan& to) const;
  void add_rows(int shape, const std::map<std::int32_t, Index>& star_at, Plan& to) const;
  bool is_whole(const BoxLattice& boxes, const Row& row) const;
  void take(BoxLattice& boxes) const;

  const VecList& rest_;
  const std::optional<LatticeFrame>& frame_;
  PackedBody& body_;
  std::vector<Index> box_of_;                       // by star: the box in the octant of its high sides, or none
  std::vector<bool> taken_;                         // by star
  std::vector<Plan> plans_;                         // by cluster; empty: no grid
  std::vector<std::vector<std::int32_t>> octants_;  // by cluster, [rows][lanes]
  std::vector<Start> starts_;
};

}  // namespace phymul::cpu
