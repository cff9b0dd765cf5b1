// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/bodies.h>
#include <phymul/scene.h>

#include <span>
#include <vector>

namespace phymul {

/// What connected_bodies() returns, without its lists: of each particle the row of its body, -1 where it was removed.
struct BodyRows {
  std::vector<Index> of;  ///< [N]
  Index count = 0;
};
BodyRows body_rows(const Model& model);

/// Whether tools, threads or contacts may hold any part.
bool may_hold_any(const Scene& scene);

/// [N] whether imposed positions or joints to the world hold a particle. `joints`: with the springs that are broken.
std::vector<char> held_particles(const Scene& scene, std::span<const JointState> joints = {});

/// Parts that nothing holds, not by way of other parts to which joints tie them either.
std::vector<ConnectedBody> loose_parts(const Scene& scene, const std::vector<char>& is_held,
                                       std::span<const JointState> joints = {});

/// A particle of the first of them that loads push; -1: none, or where something may hold any.
Index first_loose(const Scene& scene, std::span<const JointState> joints = {});

}  // namespace phymul
