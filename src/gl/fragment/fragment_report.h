// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to one texel on the device: one small read instead of the state.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fragment_contacts.h"
#include "fragment_state.h"
#include "fragment_tools.h"
#include "fragment_volumes.h"
#include "gl/objects/pass.h"
#include "gl/solver/device.h"
#include "gl/solver/report_copy.h"

namespace phymul::gl {

class FragmentReport {
 public:
  FragmentReport(const ShaderLibrary& library, Index particles);

  /// Of the state a batch has reached, and of what its steps told of tools, kept volumes and contacts; null: there are
  /// none.
  void request(const Texture& displacement, const Texture& velocity, const Texture& measured, FragmentTools* tools,
               const FragmentVolumes* volumes, FragmentContacts* contacts);
  BatchReport take();
  std::span<const ToolSums> tool_sums() const { return tool_sums_; }

 private:
  struct Level {
    Texture events, maxima;
    Framebuffer target;
    int rows = 0;
  };

  const ShaderLibrary* library_;
  Pass first_, further_;
  std::optional<Pass> tools_added_;
  Index particles_;
  std::vector<Level> levels_;
  ReportCopy copy_;
  std::vector<ToolSums> tool_sums_;
  std::size_t tool_rows_ = 0;  // of which four are behind the report; then volumes, one texel of contacts
  std::size_t volumes_ = 0, volume_rows_ = 0;
  FragmentContacts* contacts_ = nullptr;  // of what was requested last
};

}  // namespace phymul::gl
