// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/bodies.h>
#include <phymul/scene.h>

#include <vector>

namespace phymul {

/// [N] whether imposed positions or joints to the world hold a particle.
std::vector<char> held_particles(const Model& model, const Scene& scene);

/// Parts that nothing holds, not by way of other parts to which joints tie them either.
std::vector<ConnectedBody> loose_parts(const Model& model, const Scene& scene, const std::vector<char>& is_held);

/// A particle of the first of them that loads push; -1: none. Tools and contacts may hold any part: -1 with them.
Index first_loose(const Scene& scene);

}  // namespace phymul
