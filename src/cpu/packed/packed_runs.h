// SPDX-License-Identifier: MIT
//
// Links of a lattice packed as runs (simd::Runs).
#pragma once

#include <unordered_map>
#include <vector>

#include "aligned_arrays.h"
#include "cpu/simd/job.h"

namespace phymul::cpu {

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

}  // namespace phymul::cpu
