// SPDX-License-Identifier: MIT
#pragma once

#include "box_lattice.h"
#include "cluster_slots.h"
#include "grid_packer.h"
#include "hexahedra.h"

namespace phymul::cpu {

/// Packs hexahedra of few shapes, cluster by cluster; TermPacker's calls.
class LatticePacker {
 public:
  /// Takes what boxes it finds out of `hexahedra`.
  LatticePacker(Hexahedra& hexahedra, const VecList& rest, const std::optional<LatticeFrame>& frame, Index size,
                std::size_t clusters, PackedBody& body);

  void pack(int c, Slots& slots);
  void fill_idle_lanes(int c, std::int32_t idle);
  void point(int c, simd::Job& job) const;
  double cost(const simd::Job& job) const;  ///< ns a step, rough

 private:
  struct Start {
    std::size_t hexahedron, star, box;
  };

  int pack_cells(const std::vector<Hexahedron>& all, const std::vector<Index>& here, Slots& slots, Floats& to,
                 Offsets& shape_of);
  int pack_stars(const std::vector<Index>& here, bool whole, Slots& slots);

  PackedBody& body_;
  BoxLattice boxes_;
  GridPacker grid_;
  std::vector<Hexahedron> hexahedra_;                                       // those that are no boxes
  std::vector<std::vector<Index>> hexahedron_rows_, box_rows_, star_rows_;  // by cluster
  std::vector<Start> starts_;
};

}  // namespace phymul::cpu
