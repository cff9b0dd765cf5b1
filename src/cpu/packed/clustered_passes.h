// SPDX-License-Identifier: MIT
//
// The elastic forces of a body of attractors, springs, volumes and walls: the kernels of its clusters, shared out over
// threads.
#pragma once

#include <vector>

#include "base/thread_pool.h"
#include "cluster_claims.h"
#include "cpu/simd/instruction_set.h"
#include "packed_body.h"
#include "simd_profile.h"

namespace phymul::cpu {

class ClusteredPasses {
 public:
  /// `body`, `kernels`: must outlive it. `far`: a step finds hardly anything in a core's own caches.
  ClusteredPasses(const PackedBody& body, const simd::Kernels& kernels, int parts, bool far);

  /// `u`: [places] m; `force`: null where nothing pushes, or [PackedBody::force_rows] N, `pull`: null where particles
  /// give no pull, or [places] N; both written. `laps`: of the calling thread; `no_laps`: those of the others.
  void run(const char* u, char* force, char* pull, ThreadPool& pool, WorkLaps& laps, WorkLaps& no_laps);
  /// Of a body of Law::particle_averaged: adds what run() found to the forces of its particles.
  void add_to_particles(char* force, WorkLaps& laps) const;

 private:
  void add_cluster(int c, const char* u, char* force, char* pull, char* near, WorkLaps& laps) const;

  const PackedBody& body_;
  const simd::Kernels& kernels_;
  ClusterClaims claims_;
  std::vector<Floats> near_u_;  // [parts] displacements of the cluster a part is at
  const bool rows_far_, far_;
};

}  // namespace phymul::cpu
