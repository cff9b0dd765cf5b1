// SPDX-License-Identifier: MIT
//
// Verlet's scheme keeps the velocity v- of half a step before the state's time and steps to v+ = d v- + a dt. The
// velocity of the state's own time is their mean, v = ((1 + d) v- + a dt) / 2. What tools, contacts and volume
// constraints do in the step is part of a.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

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

}  // namespace phymul
