// SPDX-License-Identifier: MIT
#include "half_step.h"

#include <phymul/elasticity.h>
#include <phymul/load_frame.h>

#include "interaction/joint_set.h"

namespace phymul {
namespace {

/// Calls change(velocity, acceleration) for every free coordinate.
template <class Change>
void for_free_coordinates(const TopologyTextures& topology, const Scene& scene, State& state, Change change) {
  LoadFrame loads;
  scene.prepare(loads);
  scene.evaluate(state.time, loads);
  VecList force(state.position.size());
  elastic_forces(topology, state.position, force);
  add_joint_forces(scene, state, force);
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (!loads.force.empty()) force[i] += loads.force[i];
    const Vec3 acceleration = loads.gravity + force[i] / topology.mass[i];
    for (int axis = 0; axis < topology.dimension; ++axis) {
      const bool imposed = !loads.fixed.empty() && (loads.fixed[i] >> axis & 1);
      if (!imposed) change(state.velocity[i][axis], acceleration[axis]);
    }
  }
}

}  // namespace

void to_own_time(const TopologyTextures& topology, const Scene& scene, const HalfStep& step, State& state) {
  for_free_coordinates(topology, scene, state,
                       [&](double& v, double a) { v = ((1.0 + step.d) * v + step.dt * a) / 2.0; });
}

void to_half_step_before(const TopologyTextures& topology, const Scene& scene, const HalfStep& step, State& state) {
  for_free_coordinates(topology, scene, state,
                       [&](double& v, double a) { v = (2.0 * v - step.dt * a) / (1.0 + step.d); });
}

}  // namespace phymul
