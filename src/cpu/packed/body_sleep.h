// SPDX-License-Identifier: MIT
//
// SolverOptions::sleep_tolerance: which blocks of a body of Law::particle_averaged a step has to compute.
//
// A block's next state is a function of the displacements that reach it (SleepBlocks), its own velocities, its loads
// and the step. Where none of them changed in the last step, this one would repeat its result bit for bit, and is
// skipped. Stresses, forces and summaries of such a block stay valid where they are. With a tolerance above 0 a block
// that hardly moves is held where it is; then it no longer changes, and so no longer wakes others.
#pragma once

#include <phymul/topology_textures.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/thread_pool.h"
#include "cpu/simd/job.h"
#include "device/float_range.h"
#include "packed_body.h"

namespace phymul::cpu {

// The summaries of the moving pass: one per part, and the reduction over all parts.

/// A line of the caches for each part.
struct alignas(64) PartSummary {
  simd::MoveSummary summary;
};

inline simd::MoveSummary summary_of(std::span<const PartSummary> parts) {
  simd::MoveSummary all;
  for (const auto& [part] : parts) {
    all.acceleration = std::max(all.acceleration, part.acceleration);
    all.force = std::max(all.force, part.force);
    all.speed = std::max(all.speed, part.speed);
    all.motion = std::max(all.motion, part.motion);
    all.displacement = std::max(all.displacement, part.displacement);
    all.runaway = all.runaway || part.runaway;
    all.cut = all.cut || part.cut;
  }
  return all;
}

/// A body of Law::particle_averaged divided into blocks of neighbouring particles, and what their motion depends on.
/// Block b has the places b * size ... (b + 1) * size - 1. The division depends on nothing but the order of places,
/// so never on the number of threads.
struct SleepBlocks {
  /// Places in a block, a multiple of all lanes. Fewer cost more of a step for their own bookkeeping, more keep more
  /// particles awake around those that move.
  static constexpr int size = 128;

  int count = 0;
  std::vector<std::int32_t> first_reached;  ///< [count + 1] of `reached`
  std::vector<std::int32_t> reached;        ///< per block: those whose next state depends on its displacements
  std::vector<std::int32_t> first_further;  ///< [count + 1] of PackedAverages::further

  std::span<const std::int32_t> reach(int block) const {
    return {reached.data() + first_reached[block], reached.data() + first_reached[block + 1]};
  }
  static std::size_t of_quad(std::size_t quad) { return quad / size; }  // quad_of() stays within a slice
};

/// `body`: of the same tables.
SleepBlocks make_sleep_blocks(const TopologyTextures& topology, const PackedBody& body);

/// Slices in ascending order, without gaps inside a range.
class SliceRanges {
 public:
  void reserve(std::size_t ranges) { ranges_.reserve(ranges); }
  void clear();
  void add(int first, int last);  ///< not before the first of the last range

  /// Calls call(first, last) for the slices of one of `parts` equal shares.
  template <class Call>
  void share(int part, int parts, const Call& call) const {
    const auto bound = [&](int k) { return static_cast<int>(std::int64_t{total_} * k / parts); };
    int before = 0;
    for (const auto& [first, last] : ranges_) {
      const int from = std::max(bound(part), before), to = std::min(bound(part + 1), before + last - first);
      if (from < to) call(first + from - before, first + to - before);
      before += last - first;
    }
  }

 private:
  std::vector<std::pair<int, int>> ranges_;
  int total_ = 0;
};

class BodySleep {
 public:
  /// `held_after`: consecutive steps below the thresholds after which a block is held.
  BodySleep(const TopologyTextures& topology, const PackedBody& body, int held_after);

  /// The next step computes all blocks, and none of them is held any longer.
  void wake_all();
  /// The next step computes all blocks: something else than their state changed.
  void compute_all() { everything_ = true; }
  /// [blocks] for marks of blocks whose loads changed since the last step.
  std::uint8_t* changed_loads() { return stirred_.data(); }

  /// Chooses the blocks of a step. Blocks below the thresholds are held; thresholds of 0: none is.
  void begin(const simd::Move& move, const RestThresholds& hold);
  bool all() const { return chosen_.size() == static_cast<std::size_t>(blocks_.count); }
  bool none() const { return chosen_.empty(); }

  /// Further domains (PackedAverages::further) of the chosen blocks.
  void copy_displacements(char* u, char* next_u) const;
  void gather_forces(char* force) const;
  /// Calls work(part, parts), by several threads where that is worth it.
  template <class Work>
  void run(ThreadPool& pool, const Work& work) const {
    if (chosen_.size() < worth_threads) {
      work(0, 1);
    } else {
      pool.run(work);
    }
  }
  /// The slots of the chosen blocks, those of further domains included.
  const SliceRanges& slots() const { return slots_; }
  void move(const simd::Move& move, const simd::Kernels& kernels, ThreadPool& pool);
  /// Of all blocks, as after the last move().
  const simd::MoveSummary& summary() const { return summary_; }

  /// Tools push particles of these quads in this step: their blocks are moved again, and not held.
  void push(std::span<const std::size_t> quads);
  /// The particle's displacement changes after the last move() of the step.
  void shift(std::size_t quad);
  /// The step counts. If it does not, compute_all().
  void accept();

  /// How long each block was below the thresholds, for snapshots: with the same numbers, states and loads further steps
  /// are the same. Empty unless some block was.
  std::vector<std::uint8_t> memory() const;
  void require_fitting(std::span<const std::uint8_t> memory) const;  ///< throws Error if it is of another body
  void remember(std::span<const std::uint8_t> memory);

 private:
  /// Fewer blocks are not worth waking another thread for.
  static constexpr std::size_t worth_threads = 4;

  void choose();
  void move_block(const simd::Move& move, const simd::Kernels& kernels, int block);
  void hold_if_still(const simd::Move& move, int block, int first, int last);
  bool is_carried(const simd::Move& move, int first_place, int last_place) const;

  const PackedBody& body_;
  const SleepBlocks blocks_;
  const std::int32_t held_after_;
  RestThresholds hold_;
  std::array<float, 8> before_{};  ///< of the last step: what all blocks depend on
  bool everything_ = true;
  std::vector<std::int32_t> chosen_;
  SliceRanges slots_;
  std::vector<std::uint8_t> changed_, stirred_, pushed_, is_chosen_;  // [blocks]
  std::vector<std::int32_t> still_, still_after_;                     // [blocks] steps, before and after this step
  std::vector<PartSummary> summaries_;                                // [blocks]
  simd::MoveSummary summary_;
};

}  // namespace phymul::cpu
