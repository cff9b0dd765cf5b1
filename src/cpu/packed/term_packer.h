// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

#include <unordered_map>

#include "packed_rows.h"

namespace phymul {

struct Triples;

namespace cpu {

/// Packs bases that can be enumerated, cluster by cluster; TermPacker's calls. Slices with the same constants share
/// them: on a lattice nearly all do.
class TriplePacker {
 public:
  TriplePacker(const TopologyTextures& topology, std::size_t clusters, PackedBody& body);

  bool enumerates() const { return enumerates_; }
  void pack(int c, Slots& slots);
  void fill_idle_lanes(int c, std::int32_t idle);
  void point(int c, simd::Job& job) const;
  double cost(int c) const;  ///< ns a step, rough; of the cluster packed last

 private:
  struct Start {  // where a cluster begins in the arrays of the body
    std::size_t slice = 0, offset = 0;
  };

  void pack_slice(Index first, Index end, Slots& slots);
  void pack_triple(const Triples& of, Index j, Index k, Index l, LaneRows& rows, Index row, int lane) const;
  bool is_thin(const Triples& of) const;
  void sum_heights(Index count, std::size_t edges, std::size_t pairs, std::size_t triples);
  std::size_t share_constants(std::size_t first);

  const TopologyTextures& t_;
  PackedBody& body_;
  const bool enumerates_;
  std::vector<Start> starts_;
  std::unordered_multimap<std::size_t, std::size_t> known_;  // hash of constants, where they begin
};

}  // namespace cpu

}  // namespace phymul

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
