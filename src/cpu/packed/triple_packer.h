// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

#include <unordered_map>

#include "cluster_slots.h"
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
