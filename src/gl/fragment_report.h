// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to one texel on the device: one small read instead of the state.
#pragma once

#include <vector>

#include "gl/device.h"
#include "gl/fragment_state.h"
#include "gl/pass.h"
#include "gl/report_copy.h"

namespace phymul::gl {

class FragmentReport {
 public:
  FragmentReport(const ShaderLibrary& library, Index particles);

  /// Of the state a batch has reached.
  void request(const Texture& displacement, const Texture& velocity, const Texture& measured);
  BatchReport take() { return copy_.take(); }

 private:
  struct Level {
    Texture events, maxima;
    Framebuffer target;
    int rows = 0;
  };

  Pass first_, further_;
  Index particles_;
  std::vector<Level> levels_;
  ReportCopy copy_;
};

}  // namespace phymul::gl
