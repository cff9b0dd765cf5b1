// SPDX-License-Identifier: MIT
//
// A body packed for the SIMD kernels: particles renumbered and divided into clusters, terms packed lane by lane
// (simd/job.h). The division depends on the body and the lanes alone, never on the number of threads, so that sums keep
// their order. A body with its particles renumbered, for locality (locality_order.h).
#pragma once

#include <phymul/topology_textures.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "aligned_arrays.h"
#include "cpu/simd/job.h"
#include "packed_averages.h"

namespace phymul::cpu {

/// The same body with particle order[i] as particle i. Rows of bases follow their owners; springs, volumes and cells
/// are sorted by their first particle; neighbour rows keep their order within a particle. Padding is dropped.
TopologyTextures renumbered(const TopologyTextures& topology, const std::vector<Index>& order);

struct Cluster {
  simd::Job job;                   ///< without u and force, which belong to a step
  std::int32_t first = 0;          ///< particle of slot 0
  std::int32_t own = 0;            ///< slots of own particles, a multiple of the lanes
  std::vector<bool> pushed;        ///< of the halo: whether the cluster's terms have forces for it
  std::vector<std::int32_t> halo;  ///< quads of the particles of the slots after those
  std::int64_t force_first = 0;    ///< quad of slot 0 among the forces of all clusters, a multiple of 4
  double cost = 0.0;               ///< rough, ns per step
  std::int32_t slots() const { return own + static_cast<std::int32_t>(halo.size()) + 1; }
};

struct PackedBody {
  int lanes = 0;
  std::vector<Index> order;     ///< [particles] row of the model
  std::int32_t places = 0;      ///< particles, filled up to whole slices
  std::int64_t force_rows = 0;  ///< of all clusters, the last one always zero; none where nothing pushes()
  std::vector<Cluster> clusters;
  simd::BaseUse use = simd::BaseUse::conservative;
  bool plane = false, bounded = false;

  // Arrays of the jobs and of simd::Move.
  Offsets base_first, spring_first, enumerated_first, enumerated_neighbours, enumerated_offsets, own, halo_first, halo,
      give_first;
  Floats bases, enumerated, springs, volumes, walls, stiffness, inverse_mass, mass, give;

  PackedAverages averages;  ///< of Law::particle_averaged, whose bodies have clusters of walls alone
  /// Of such clusters: the quad of a particle's force, and a row that a cluster adds to it.
  std::vector<std::array<std::int32_t, 2>> wall_sums;

  std::size_t most_slots() const;  ///< of a cluster
  int slices() const { return places / lanes; }
  /// Of a place of `order`, in displacements, pulls and loads.
  std::size_t quad_of(std::size_t place) const {
    return static_cast<std::size_t>(simd::quad_of(static_cast<std::int32_t>(place), lanes));
  }
  /// Whether terms have forces of their own for particles, and not only pulls that the move gathers.
  bool pushes() const {
    return use != simd::BaseUse::attractor || !(springs.empty() && volumes.empty() && walls.empty());
  }
  bool gives() const { return use == simd::BaseUse::attractor && !(bases.empty() && enumerated.empty()); }
  /// Takes over what changed of these domains, of Law::particle_averaged, and of the masses of their particles, and
  /// packs all walls anew. Whether all domains were packed anew, because links went by runs; places stay.
  bool edit(const TopologyTextures& topology, std::span<const Index> domains);
  bool averaged() const { return averages.slots > 0; }
  double cost() const;  ///< ns per step, rough
  /// Threads for a step: as many as asked for, or for 0 as the machine has and the work is worth. No more than a host
  /// lends, where there is one.
  int threads_for(int asked, const TaskRunner* host) const;
  /// Bytes that a step reads and writes if nothing stays in a cache between steps, without the scene's loads.
  double bytes_a_step() const;
};

/// Throws Error where a constant is not a float or an offset not 32 bits.
std::unique_ptr<PackedBody> make_packed_body(const TopologyTextures& topology, int lanes);

}  // namespace phymul::cpu
