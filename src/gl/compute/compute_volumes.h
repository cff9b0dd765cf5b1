// SPDX-License-Identifier: MIT
//
// The volumes that a scene keeps: their rows among those of its loads, and the kernels that end a step with them.
#pragma once

#include <utility>

#include "compute_state.h"
#include "device/float_volumes.h"

namespace phymul::gl {

class ComputeVolumes {
 public:
  /// Takes rows from `first` on.
  ComputeVolumes(const FloatVolumes& volumes, std::int64_t first, const ComputeTables& tables);

  std::int64_t end() const { return end_; }
  int count() const { return count_; }
  void write(const FloatVolumes& volumes, StorageBuffer& rows) const;
  void place(Kernel& kernel) const;
  std::int64_t roots_row() const { return roots_row_; }  ///< [count]

  int facet_sums() const { return facet_sums_; }
  /// Turns of loops that a step takes of one group: at most.
  std::int64_t turns(int group) const;

 private:
  std::vector<Int4> placed(std::vector<Int4> rows, std::size_t corners) const;

  const ComputeTables* tables_;
  int count_, levels_, sums_, facet_sums_;
  Index most_around_;
  std::int64_t laws_row_ = 0, ranges_row_ = 0, around_row_ = 0, facets_row_ = 0, edges_row_ = 0, nodes_row_ = 0;
  std::int64_t levels_row_ = 0, along_row_ = 0, sums_row_ = 0, roots_row_ = 0, end_ = 0;
};

/// Dispatched after a step by many groups, before the next.
class KeepingKernels {
 public:
  KeepingKernels() = default;
  /// `sums` of one group or many, `step` of many.
  KeepingKernels(Kernel sums, Kernel step) : sums_(std::move(sums)), step_(std::move(step)) {}

  explicit operator bool() const { return static_cast<bool>(sums_); }
  Kernel& step() { return step_; }  ///< for constants and loads
  void place(const ComputeVolumes& volumes);
  /// Step `number` of the batch, from the current pair to the free one, where the step before left it.
  void run(const ComputeState& state, int number, int particles);

 private:
  Kernel sums_, step_;
  int facet_sums_ = 0;
};

/// Files of a kernel in which a step by many groups leaves what KeepingKernels end, up to before step_pass.glsl.
const ShaderFiles& keeping_step_files();
/// Those of the kernel that sums.
const ShaderFiles& keeping_sums_files();
/// Those with which a step ends, after measure_step.glsl and keeping_step_files() or kept_tables.glsl.
const ShaderFiles& keeping_end_files();

}  // namespace phymul::gl
