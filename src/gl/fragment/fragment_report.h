// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to one texel on the device: one small read instead of the state.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fragment_scene.h"
#include "gl/solver/device.h"
#include "gl/solver/report_copy.h"

namespace phymul::gl {

class FragmentReport {
 public:
  FragmentReport(const ShaderLibrary& library, Index particles);

  /// Of the state a batch has reached, and of what its steps told of tools and kept volumes. Waits for the device.
  BatchReport read(const Texture& displacement, const Texture& velocity, const Texture& measured, FragmentScene& scene);
  std::span<const ToolSums> tool_sums() const { return tool_sums_; }

 private:
  const ShaderLibrary* library_;
  Pass first_, further_;
  std::optional<Pass> tools_added_;
  Reduction reduction_;
  ReportCopy copy_;
  std::vector<ToolSums> tool_sums_;
};

}  // namespace phymul::gl
