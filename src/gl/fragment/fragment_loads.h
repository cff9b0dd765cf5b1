// SPDX-License-Identifier: MIT
//
// A scene's loads in textures.
#pragma once

#include "gl/objects/pass.h"
#include "gl/solver/load_table.h"

namespace phymul::gl {

class FragmentLoads {
 public:
  /// Room for the values of as many instants.
  FragmentLoads(const Scene& scene, int instants);

  const LoadKind& kind() const { return table_.kind(); }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  /// Of an instant given to evaluate(), m/s^2: gravity and uniform accelerations.
  const Float4& gravity(std::size_t instant) const { return table_.gravity()[instant]; }

  void bind(Pass& pass) const;

 private:
  LoadTable table_;
  Texture index_, parts_, values_;  // null where nothing but gravity acts
};

}  // namespace phymul::gl
