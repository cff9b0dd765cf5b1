// SPDX-License-Identifier: MIT
//
// A body whose cells tests remove or cut, and its tables against those of a body built anew.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "bodies.h"

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

/// The tables of the simulation's model as it is now, with the stabiliser that the body has.
inline TopologyTextures built_anew(const Simulation& sim) {
  return build_topology(sim.model(), {.stabiliser = sim.solver().topology().options.stabiliser});
}

/// Cuts, removals and returns in any order.
struct RandomEdits {
  Simulation& sim;
  CutSurface (*next_cut)(std::mt19937&, const Model&);
  const Model whole = sim.model();
  std::vector<Snapshot> kept{sim.snapshot()};
  std::mt19937 random{11};
  int edits = 0, cuts = 0, refused = 0;

  void make_one() {
    const auto count = static_cast<Index>(sim.model().cells.size());
    if (random() % 3 == 0) {
      const auto row = static_cast<Index>(random() % count);
      if (sim.model().cells[row].type != CellType::line) sim.remove_cells(std::vector<Index>{row});
    } else if (random() % 5 == 0) {
      sim.restore(kept[random() % kept.size()]);
    } else {
      try {
        cuts += sim.cut(next_cut(random, whole)) ? 1 : 0;
      } catch (const Error& error) {
        ASSERT_EQ(error.code(), ErrorCode::not_supported) << error.what();
        ++refused;
        sim.restore(kept.front());
      }
    }
    if (++edits % 7 == 0 && kept.size() < 20) kept.push_back(sim.snapshot());
  }
};

/// Largest difference of the elastic forces of two tables at random places, over the largest force.
inline double difference_of_forces(const TopologyTextures& a, const TopologyTextures& b, const Model& model,
                                   std::uint32_t seed = 5) {
  VecList x = random_positions(model, 0.2, seed), of_a(x.size()), of_b(x.size());
  elastic_forces(a, x, of_a);
  elastic_forces(b, x, of_b);
  double largest = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    largest = std::max(largest, of_b[i].norm());
    apart = std::max(apart, (of_a[i] - of_b[i]).norm());
  }
  return apart / largest;
}

}  // namespace phymul::test
