// SPDX-License-Identifier: MIT
//
// What a batch of steps has to tell, brought down to one texel on the device: one small read instead of the state.
#pragma once

#include <vector>

#include "gl/fragment_state.h"
#include "gl/pass.h"

namespace phymul::gl {

/// Steps count from 1 within the batch; 0: never.
struct BatchReport {
  int runaway_step = 0;  ///< first in which a particle ran away
  Index particle = -1;   ///< the first of them by number
  bool cut = false;      ///< an elastic force was; false too where a particle ran away
  int first_unquiet = 0, last_unquiet = 0;
  /// Of the last step, if it was measuring.
  double max_speed = 0.0, max_acceleration = 0.0, max_force = 0.0, max_displacement = 0.0;
};

class FragmentReport {
 public:
  FragmentReport(const ShaderLibrary& library, Index particles);

  /// Of the state a batch has reached. Waits for the device.
  BatchReport read(const Texture& displacement, const Texture& velocity, const Texture& measured);

 private:
  struct Level {
    Texture events, maxima;
    Framebuffer target;
    int rows = 0;
  };

  Pass first_, further_;
  Index particles_;
  std::vector<Level> levels_;
};

}  // namespace phymul::gl
