// SPDX-License-Identifier: MIT
//
// A body of Law::particle_averaged packed for the kernels (simd::Averaged).
#pragma once

#include <phymul/topology_textures.h>

#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "aligned_arrays.h"
#include "cpu/simd/job.h"

namespace phymul::cpu {

/// Links of a lattice packed as runs (simd::Runs).
struct PackedRuns {
  std::vector<simd::Run> runs;  ///< and where the last one ends; none: links go slot by slot
  std::vector<simd::Stencil> stencils;
  std::vector<simd::RunLink> links;
  Offsets first_run;
  std::int64_t stride = 0;
  double run_links = 0.0;   ///< that a pass goes through, `lanes` slots each
  double slot_links = 0.0;  ///< slot by slot

  bool empty() const { return runs.empty(); }
  simd::Runs job(float* components) const;
  std::size_t component_floats() const { return simd::run_components * static_cast<std::size_t>(stride); }
};

/// Takes slots one after another.
class RunPacker {
 public:
  RunPacker(int lanes, PackedRuns& to) : lanes_(lanes), to_(to) {}
  /// The links of the next slot; reordered.
  void add(std::vector<simd::RunLink>& links);
  /// Whether runs are so long, so far, that going by them is faster than slot by slot.
  bool worthwhile() const;
  void finish();

 private:
  std::int32_t stencil_of(const std::vector<simd::RunLink>& links);
  void end_run();

  int lanes_;
  PackedRuns& to_;
  std::int32_t slots_ = 0;
  std::unordered_map<std::size_t, std::int32_t> stencils_;  // by hash: the first one that came with it
};

struct PackedAverages {
  int lanes = 0;
  bool plane = false;
  std::int32_t slots = 0;  ///< a multiple of the lanes; none: a body of another law
  /// Quads of further domains of a particle: (its own, the domain's). Each step copies displacements there, and adds
  /// forces from there.
  std::vector<std::pair<std::int32_t, std::int32_t>> further;
  Offsets link_range, link, stress_row, force_row;
  Floats constants, links;
  PackedRuns runs;                     ///< in place of links
  std::vector<Index> domain_of_place;  ///< [slots] row of TopologyTextures::domains, none where there is no domain
  /// Of edits; empty before the first one.
  std::vector<std::int32_t> place_of_domain;
  struct Room {
    std::int32_t offsets = 0;          ///< of `link`, from the slot's first
    std::int32_t first = 0, rows = 0;  ///< of `links`, for either pass; rows 0: those that slots may share
  };
  std::vector<Room> rooms;  ///< [slots]

  std::size_t stress_floats() const;  ///< of what job() takes for stresses
  int slices() const { return lanes > 0 ? slots / lanes : 0; }
  simd::Averaged job(char* u, char* stress, char* force) const;
  void copy_displacements(char* u) const;
  void gather_forces(char* force) const;
  void gather_forces(char* force, int first, int last) const;  ///< of these rows of `further`
  /// Takes over what changed of these domains. Not for runs.
  void edit(const TopologyTextures& topology, std::span<const Index> domains);
  double cost() const;   ///< ns per step, rough
  double bytes() const;  ///< that a step reads and writes, beside displacements

  /// Slices at which `parts` threads begin, [parts + 1], about as many links each.
  std::vector<int> shared_out(int parts) const;
};

/// Runs are for bodies whose `order` has long ones.
enum class AveragedLinks { by_slot, runs };

/// `order`: row of the model at each place; `places`: those, filled up to whole slices. Nothing, without slots, where
/// runs are too short to gain. Throws Error where a constant is not a float or an offset not 32 bits.
PackedAverages pack_averages(const TopologyTextures& topology, const std::vector<Index>& order, std::int32_t places,
                             int lanes, AveragedLinks links);

}  // namespace phymul::cpu
