// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to two rows: one small read instead of the state.
#pragma once

#include "gl/compute_passes.h"

namespace phymul::gl {

class ComputeReport {
 public:
  ComputeReport(const ShaderLibrary& library, const ComputePasses& passes, const ComputeState& state,
                const ComputeLimits& limits);

  /// Of the state in a pair, which the last step wrote and measured. Waits for the device.
  BatchReport read(const ComputeState& state, int pair);

 private:
  Kernel kernel_;
  Index particles_;
  int groups_;
};

}  // namespace phymul::gl
