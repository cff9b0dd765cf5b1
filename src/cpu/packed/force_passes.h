// SPDX-License-Identifier: MIT
//
// The elastic forces of a body, pass by pass of the kernels, shared out over threads.
//
// Who computes which cluster of a body in a step. Each part of the threads has a run of clusters, the same in every
// step, so that their constants stay in its core's caches. But processors differ: one shares its core with another
// program, or is of a slower kind. A part that is through with its run takes from the end of another's.
#pragma once

#include <phymul/elasticity.h>

#include <atomic>
#include <cstdint>
#include <vector>

#include "base/thread_pool.h"
#include "body_sleep.h"
#include "packed_body.h"
#include "simd_profile.h"

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

/// The elastic forces of a body of attractors, springs, volumes and walls: the kernels of its clusters, shared out over
/// threads.
class ClusteredPasses {
 public:
  /// `body`, `kernels`: must outlive it. `far`: a step finds hardly anything in a core's own caches.
  ClusteredPasses(const PackedBody& body, const simd::Kernels& kernels, int parts, bool far);

  /// `u`: [places] m; `force`: null where nothing pushes, or [PackedBody::force_rows] N, `pull`: null where particles
  /// give no pull, or [places] N; both written. `last`: of a call, after which growth() is asked. `laps`: of the
  /// calling thread; `no_laps`: those of the others.
  void run(const char* u, char* force, char* pull, bool last, ThreadPool& pool, WorkLaps& laps, WorkLaps& no_laps);
  /// frequency_growth() of the last such run, infinite but for walls alone.
  double growth(const TopologyTextures& topology) const;
  /// Of a body of Law::particle_averaged: adds what run() found to the forces of its particles.
  void add_to_particles(char* force, WorkLaps& laps) const;

 private:
  void add_cluster(int c, const char* u, char* force, char* pull, char* near, float* stiffening, WorkLaps& laps) const;

  const PackedBody& body_;
  const simd::Kernels& kernels_;
  ClusterClaims claims_;
  std::vector<Floats> near_u_;  // [parts] displacements of the cluster a part is at
  Floats stiffening_;           // [clusters][lanes] simd::Job::wall_stiffening
  const bool rows_far_, far_;
};

/// The elastic forces of a body of Law::particle_averaged: its kernels, pass by pass, shared out over threads.
class AveragedPasses {
 public:
  /// `body`, `kernels`: must outlive it.
  AveragedPasses(const TopologyTextures& topology, const PackedBody& body, const simd::Kernels& kernels, int parts);

  /// Takes factors of the stiffness of each material (Scene::stiffness_factors). Whether they changed; allocates where
  /// there were none before.
  bool scale(const TopologyTextures& topology, const std::vector<double>& of_materials);

  /// `force`: [slots] N, written; `u`: [slots] m, whose rows of further domains are written. `sleep`: null, or what
  /// says which blocks are computed; then those rows of `next_u` are written too. `dissipation`: null, or that of the
  /// material. `last`: of a call, after which strain() is asked.
  void run(char* force, char* u, char* next_u, const simd::Dissipation* dissipation, const BodySleep* sleep, bool last,
           ThreadPool& pool, WorkLaps& laps);

  /// strain_summary() of the last such run, of what it computed: what sleeps counts as at rest.
  StrainSummary strain(const TopologyTextures& topology) const;

 private:
  template <class Pass>
  void for_each_pass(const simd::Averaged& job, WorkLaps& laps, const Pass& pass) const;

  const PackedBody& body_;
  const simd::Kernels& kernels_;
  const int energy_;
  const double growth_exponent_;
  Floats stress_, sums_, condition_;
  std::vector<double> of_materials_;
  Floats factor_;           // simd::Averaged::factor
  std::vector<int> first_;  // [parts + 1] slice
};

}  // namespace phymul::cpu
