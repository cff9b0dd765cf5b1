// SPDX-License-Identifier: MIT
//
// Who computes which cluster of a body in a step. Each part of the threads has a run of clusters, the same in every
// step, so that their constants stay in its core's caches. But processors differ: one shares its core with another
// program, or is of a slower kind. A part that is through with its run takes from the end of another's.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "packed_body.h"

namespace phymul::cpu {

class ClusterClaims {
 public:
  ClusterClaims(const PackedBody& body, int parts);

  /// Makes all clusters to be had again. To be called while no part takes any.
  void begin();
  /// A cluster that `part` is to compute, and no other; -1: none is left for it.
  int take(int part);

 private:
  /// Of one part. A line of the caches of its own.
  struct alignas(64) Run {
    std::atomic<std::uint64_t> left{
        0};                 ///< the clusters not taken: the first, and in the upper half the one after the last
    std::uint64_t all = 0;  ///< the same when a step begins
  };
  int take_from_another();

  std::vector<Run> runs_;  // [parts]
};

}  // namespace phymul::cpu
