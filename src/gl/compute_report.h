// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to two rows: one small read instead of the state.
#pragma once

#include "gl/compute_passes.h"
#include "gl/report_copy.h"

namespace phymul::gl {

class ComputeReport {
 public:
  ComputeReport(const ShaderLibrary& library, const ComputePasses& passes, const ComputeState& state,
                const ComputeLimits& limits);

  /// Of the state in a pair, which the last step wrote and measured.
  void request(const ComputeState& state, int pair);
  BatchReport take() { return copy_.take(); }

 private:
  Kernel kernel_;
  Index particles_;
  int groups_;
  ReportCopy copy_;
};

}  // namespace phymul::gl
