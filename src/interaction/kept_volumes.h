// SPDX-License-Identifier: MIT
//
// Scene::constrain_volume, in double precision whatever the backend's own is. Along the gradient of the volume at the
// step's start, over the masses, the particles of the surface go as far as brings the volume at the step's end to the
// wanted one (the scheme of constraints in Verlet's method, which keeps angular momentum too).
#pragma once

#include <phymul/scene.h>

#include "predicted_step.h"

namespace phymul {

class KeptVolumes {
 public:
  void follow(const Scene& scene);  ///< allocates
  bool empty() const { return surfaces_.empty(); }

  /// After all else that acts on the step. The row of a volume that cannot be restored; -1: none.
  int act(TouchedParticles& touched);

 private:
  struct Surface {
    std::vector<Index> particles;
    std::vector<std::array<Index, 3>> triangles;  // rows of `particles`
    double volume = 0.0;
    bool open = false;                    // not kept
    VecList start, end, gradient, along;  // [particles]
  };
  static bool restore(Surface& surface, TouchedParticles& touched);

  std::vector<Surface> surfaces_;
};

}  // namespace phymul
