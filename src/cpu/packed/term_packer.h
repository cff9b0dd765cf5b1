// SPDX-License-Identifier: MIT
#pragma once

#include "cluster_slots.h"
#include "packed_rows.h"
#include "triple_packer.h"

namespace phymul::cpu {

/// Packs the terms of a body, cluster by cluster, into the rows of simd/job.h.
class TermPacker {
 public:
  /// `size`: particles of a cluster.
  TermPacker(const TopologyTextures& topology, Index size, std::size_t clusters, PackedBody& body);

  void pack(int c);   ///< the terms of cluster c, whose own particles are known; clusters in order, each once
  void point_jobs();  ///< once all are packed: the arrays no longer move

  /// Rows that each particle has in its slice.
  static std::vector<Index> work_of(const TopologyTextures& topology);

 private:
  struct Start {  // where a cluster's rows begin in the arrays of the body
    std::size_t base_slice, spring_slice, volume, wall;
  };

  void pack_base_slice(const Cluster& cluster, int s, Index own);
  void pack_base(Index t, Index owner, LaneRows& rows, Index row, int lane);
  void pack_spring_slice(const Cluster& cluster, int s, Index own);
  int pack_volumes(int c);
  int pack_walls(int c);
  void fill_idle_lanes(int c);
  void estimate_cost(int c);

  const TopologyTextures& t_;
  const Index size_;
  PackedBody& body_;
  Slots slots_;
  TriplePacker triples_;
  bool slices_bases_ = false;
  std::vector<std::vector<Index>> volumes_, walls_;  // rows by cluster
  std::vector<Start> starts_;
};

}  // namespace phymul::cpu
