// SPDX-License-Identifier: MIT
//
// Takes a body to rest by real stepping, and times it. The damping is critical for the slowest motion that the load
// excites. Where that is not known yet, runs before the timed one find it: an undamped one until the kinetic energy has
// passed its first peak, a quarter of the period of the strongest motion; then damped ones, in which the fast motions
// die and the Rayleigh quotient of what still moves gives the frequency of the slow ones. A user finds it once; it is
// not in the times.
#pragma once

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace phymul::bench {

/// The slowest motion that the load excites.
struct Excited {
  double omega = 0.0;  ///< rad/s; 0: not known
  double reach = 0.0;  ///< m, largest displacement
};

struct RelaxationPlan {
  std::string backend;
  double step_share = 0.9;      ///< dt over stable_step()
  double rest_accuracy = 1e-4;  ///< at rest when what is left to go is about this part of the largest displacement
  int threads = 0;              ///< SolverOptions::threads
  double wall_cap = 20.0;       ///< s; beyond it the status is over_budget
  double patience = 60.0;       ///< in 1 / omega of the excited motion; a body still moving then is restless
  Excited excited;              ///< found where omega is 0
};

struct Relaxation {
  std::string status;  ///< "ok", or a failure's name
  std::string message;
  State state;
  int steps = 0;
  double dt = 0.0, stable_step = 0.0, rate = 0.0;
  double wall_per_step = 0.0;  ///< s, median of runs of `steps` steps in one call
  double cpu_per_step = 0.0;   ///< s of processor, all threads; of the same runs
  std::string device;
  Excited excited;
  std::map<std::string, Vec3, std::less<>> tool_force;  ///< N, of the body on each tool, mean over the last steps

  double wall_to_rest() const { return wall_per_step * steps; }
};

Relaxation refused(const Error& error);

/// `start` [N] m: where the body begins. A solver or a body that cannot be made is a status, not an exception.
Relaxation relax(std::shared_ptr<const TopologyTextures> topology, const Scene& scene, const VecList& start,
                 const RelaxationPlan& plan);

}  // namespace phymul::bench
