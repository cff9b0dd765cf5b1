// SPDX-License-Identifier: MIT
//
// Tables of a body whose materials are stiffer or softer than the model says (Scene::scale_stiffness).
#pragma once

#include <phymul/topology_textures.h>

#include <optional>
#include <span>
#include <vector>

namespace phymul {

class ScaledTables {
 public:
  /// The tables with all stiffnesses of each material times its factor [materials]; without factors the tables
  /// themselves. Valid until the next call. Copies the tables where it does so for the first time or after edits, and
  /// is to be given the same ones from then on.
  const TopologyTextures& of(const TopologyTextures& topology, std::span<const double> factors);

 private:
  std::optional<TopologyTextures> scaled_;
  std::vector<double> factors_;  // that scaled_ has
};

}  // namespace phymul
