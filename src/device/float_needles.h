// SPDX-License-Identifier: MIT
//
// FloatNeedles: the needles of a scene for backends that compute in float: what each derives from the body, and how
// much room its hole takes on a device.
#pragma once

#include <phymul/scene.h>

#include <array>
#include <vector>

namespace phymul {

struct FloatNeedles {
  explicit FloatNeedles(const Scene& scene);

  static constexpr int most_nodes = 64;  ///< of a hole: a lane of one group each

  struct One {
    int tool = 0;  ///< row of Scene::tools()
    Needle needle;
    double friction = 0.0;             ///< Coulomb's, of the tip on the surface
    double spread = 0.0, reach = 0.0;  ///< m
    int nodes = 0;  ///< twice as many as a straight hole through the body has, and some: room for tissue that is pushed
                    ///< together
    int particles = 0;  ///< a node; six times as many as are within reach of a place inside a body at rest, or all
    bool bends() const { return needle.bending_stiffness > 0.0; }
  };
  std::vector<One> needles;                  ///< in the scene's order
  std::vector<std::array<Index, 3>> facets;  ///< of the body's surface, outward
};

}  // namespace phymul
