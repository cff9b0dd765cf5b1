// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to two rows, to four for each tool and one for each kept volume: one
// small read instead of the state.
#pragma once

#include "compute_passes.h"
#include "gl/solver/report_copy.h"

namespace phymul::gl {

class ComputeReport {
 public:
  ComputeReport(const ShaderLibrary& library, const ComputePasses& passes, const ComputeState& state,
                const ComputeLimits& limits);

  /// Of the state in a pair, which the last step wrote and measured, and of what steps told of the tools and volumes
  /// among `loads`. Waits for the device.
  BatchReport read(const ComputeState& state, int pair, const ComputeLoads& loads);
  std::span<const ToolSums> tool_sums() const { return tool_sums_; }

 private:
  void sum_tools(const ComputeTools& tools);

  const ShaderLibrary* library_;
  const ComputePasses* passes_;
  ComputeLimits limits_;
  Kernel kernel_, tool_kernel_;
  Index particles_;
  int groups_;
  ReportCopy copy_;
  std::vector<ToolSums> tool_sums_;
};

}  // namespace phymul::gl
