// SPDX-License-Identifier: MIT
//
// What a solution is worth: its distance from the reference, in displacement and in force.
#pragma once

#include <phymul/topology_textures.h>

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "problem.h"

namespace phymul::bench {

struct Measures {
  std::optional<PositionError> displacement;  ///< at the sample points that are not prescribed, where there are any;
                                              ///< p95 and max in m
  std::optional<double> force_error;          ///< |R - R_ref| / |R_ref| over the components the case gives; the largest
                                              ///< of several reactions, torques and pushes
};

using ToolForces = std::map<std::string, Vec3, std::less<>>;  ///< N, of the body on each tool

/// R is what the supports of a group exert on the body: minus its elastic forces, weight and loads; or what the body
/// exerts on a tool, as the solver says it. A tool that `pushed` does not know is not measured.
Measures measure(const Problem& problem, const TopologyTextures& topology, const Scene& scene,
                 std::span<const Vec3> position, const ToolForces& pushed = {});

/// Of the null model, which has no force.
std::optional<PositionError> null_error(const Problem& problem);

struct Support {
  Vec3 force{0, 0, 0};   ///< N
  Vec3 torque{0, 0, 0};  ///< N m, about the rest centroid of the particles
};

/// What the supports of these particles exert on the body; and the tools, where they touch them.
Support support(std::span<const Index> particles, const TopologyTextures& topology, const Scene& scene,
                std::span<const Vec3> position);

}  // namespace phymul::bench
