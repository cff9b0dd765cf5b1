// SPDX-License-Identifier: MIT
//
// Takes a body to rest by real stepping, and times it. Two runs: an undamped one until the kinetic energy has passed
// its first peak, a quarter of the period of the motion the load excites; then, from the start again, the damped one
// that counts, with the critical damping of that period. The first is what a user does once and is not in the times.
#pragma once

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <memory>
#include <string>

namespace phymul::bench {

struct RelaxationPlan {
  std::string backend;
  double step_share = 0.9;      ///< dt over stable_step()
  double rest_accuracy = 1e-4;  ///< at rest when what is left to go is about this part of the largest displacement
  double wall_cap = 20.0;       ///< s; beyond it the status is over_budget
  double patience = 60.0;       ///< in 1 / omega of the excited motion; a body still moving then is restless
};

struct Relaxation {
  std::string status;  ///< "ok", or a failure's name
  std::string message;
  State state;
  int steps = 0;
  double dt = 0.0, stable_step = 0.0, rate = 0.0;
  double wall_per_step = 0.0;  ///< s, median over batches of steps
  std::string device;

  double wall_to_rest() const { return wall_per_step * steps; }
};

/// `start` [N] m: where the body begins. A solver or a body that cannot be made is a status, not an exception.
Relaxation relax(std::shared_ptr<const TopologyTextures> topology, const Scene& scene, const VecList& start,
                 const RelaxationPlan& plan);

}  // namespace phymul::bench
