// SPDX-License-Identifier: MIT
//
// What tools, threads, contacts between bodies and volume constraints would do in a step from a state, in double
// precision for all backends.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include "interaction/predicted_step.h"
#include "interaction/tool_set.h"
#include "interaction/touching.h"

namespace phymul {

class TouchNow {
 public:
  /// A step of dt, s. Tools are where the state has them and go on with the velocity of their poses; what they are told
  /// to grasp or release in the next step is left out. All arguments must live longer than this.
  TouchNow(const Scene& scene, const TopologyTextures& topology, const State& state, double dt);

  bool empty() const { return !any_; }
  /// [N] m/s: of predicted velocities (PredictedStep) those that are left.
  void act(VecList& velocity);

 private:
  const Scene& scene_;
  const State& state_;
  double dt_;
  bool any_;
  LoadFrame loads_;  // of the step's end
  ToolSet tools_;
  Touching touching_;
  TouchedParticles touched_;
};

}  // namespace phymul
