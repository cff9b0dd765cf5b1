// SPDX-License-Identifier: MIT
//
// A body whose cells tests remove.
#pragma once

#include <phymul/phymul.h>

#include <string>
#include <vector>

namespace phymul::test {

inline Model slab() {
  return make_tetrahedral_block({0.06, 0.04, 0.03}, 6, 4, 3, 0.25, 7);
}

inline std::vector<Index> cells_within(const Model& model, const Vec3& centre, double radius) {
  return model.cells_in([&](const Vec3& x) { return (x - centre).norm() < radius; });
}

inline SimulationOptions options_for(const std::string& backend) {
  SimulationOptions options;
  options.backend = backend;
  options.material = {5e3, 0.4, 1000.0};
  options.damping.rate = 10.0;
  return options;
}

}  // namespace phymul::test
