// SPDX-License-Identifier: MIT
//
// Verlet's scheme keeps the velocity v- of half a step before the state's time and steps to v+ = d v- + a dt. The
// velocity of the state's own time is their mean, v = ((1 + d) v- + a dt) / 2. What tools, contacts and volume
// constraints do in the step is part of a.
#pragma once

#include <phymul/load_frame.h>
#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include "interaction/predicted_step.h"
#include "interaction/tool_set.h"
#include "interaction/touching.h"

namespace phymul {

/// A step of dt, s, that multiplies velocities by d.
struct HalfStep {
  double dt = 0.0, d = 1.0;
};

/// m/s^2, of elastic forces, joints, loads and `further`, as below, at the state; 0 for imposed coordinates.
VecList free_accelerations(const TopologyTextures& topology, const Scene& scene, const State& state,
                           const VecList& further);

// Both take the acceleration of elastic forces, joints, loads and what touches at the state, in double precision, and
// leave velocities of imposed coordinates as they are. Tools go on with the velocities of their poses in the state.
// `further`: further forces, N, or none.
void to_own_time(const TopologyTextures& topology, const Scene& scene, const HalfStep& step, State& state,
                 const VecList& further = {});
void to_half_step_before(const TopologyTextures& topology, const Scene& scene, const HalfStep& step, State& state,
                         const VecList& further = {});

/// What tools, threads, contacts between bodies and volume constraints would do in a step from a state, in double
/// precision for all backends.
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
