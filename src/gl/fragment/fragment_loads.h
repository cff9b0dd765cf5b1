// SPDX-License-Identifier: MIT
//
// A scene's loads in textures.
#pragma once

#include "fragment_tables.h"
#include "gl/objects/pass.h"
#include "gl/solver/load_table.h"

namespace phymul::gl {

class FragmentLoads {
 public:
  /// Room for the values of as many instants. `tables` must outlive it.
  FragmentLoads(const Scene& scene, int instants, const FragmentTables& tables);

  const LoadKind& kind() const { return table_.kind(); }

  /// Takes over the values at these instants.
  void evaluate(const std::vector<double>& instants);
  /// Of an instant given to evaluate(), m/s^2: gravity and uniform accelerations.
  const Float4& gravity(std::size_t instant) const { return table_.gravity()[instant]; }

  void bind(Pass& pass) const;
  /// The pass that is multiplied by stiffness_factor.
  void bind_factors(Pass& pass) const { pass.input("stiffness_factor", factors_); }

 private:
  LoadTable table_;
  NamedTables tables_;
  Texture values_;   // null where nothing but gravity acts
  Texture factors_;  // null where no stiffness is scaled
};

}  // namespace phymul::gl
