// SPDX-License-Identifier: MIT
//
// Lattices of Law::particle_averaged, whose links go run by run (simd::Runs).
#include <gtest/gtest.h>

#include "cpu/packed/packed_body.h"
#include "support/bodies.h"
#include "support/cpu_forces.h"

namespace phymul::test {
namespace {

struct Lattice {
  std::string name;
  Model model;
  bool taken = true;
};

/// Its top pressed in around the middle.
Model dented(Model model) {
  for (Vec3& x : model.rest) {
    const double r = (x - Vec3(0.12, 0.06, 0.06)).norm();
    if (r < 0.025) x += (0.025 - r) * Vec3(0.03, 0.02, -0.3);
  }
  return model;
}

std::vector<Lattice> lattices() {
  const Model block = make_block({0.24, 0.12, 0.06}, 24, 12, 6);
  Model halves = with_material(block);
  halves.add_group("left", halves.particles_in([](const Vec3& X) { return X.x() < 0.125; }));
  set_material(halves, {50e3, 0.3, 1000.0}, "left");
  std::vector<Lattice> all;
  all.push_back({"block", with_material(block)});
  all.push_back({"far", moved(with_material(block), {0.3, -0.2, 0.1})});
  all.push_back({"uneven", with_material(make_block({0.05, 0.24, 0.09}, 6, 24, 7))});
  all.push_back({"dent", with_material(dented(block))});
  all.push_back({"two materials", halves});
  all.push_back({"strip", with_material(make_strip(0.4, 0.1, 40, 10))});
  all.push_back({"tetrahedra", with_material(make_tetrahedral_block({0.06, 0.06, 0.06}, 6, 6, 6, 0.2, 5)), false});
  return all;
}

TEST(CpuRuns, LatticesAreTaken) {
  for (const Lattice& body : lattices()) {
    const TopologyTextures tables = build_topology(body.model, {});
    for (const int lanes : {4, 8, 16}) {
      const auto packed = cpu::make_packed_body(tables, lanes);
      const cpu::PackedRuns& runs = packed->averages.runs;
      EXPECT_EQ(!runs.empty(), body.taken) << body.name << ", " << lanes;
      if (runs.empty()) continue;
      EXPECT_EQ(runs.runs.back().first, packed->averages.slots);
      // The ends of a line are alone, and some lanes of its last slice idle.
      const double least = body.name == "block" ? 0.35 * lanes : 0.2 * lanes;
      EXPECT_GT(runs.slot_links, least * runs.run_links) << body.name << ", " << lanes;
    }
  }
}

TEST(CpuRuns, EqualConstantsAreThereOnce) {
  const TopologyTextures tables = build_topology(with_material(make_block({0.24, 0.12, 0.06}, 24, 12, 6)), {});
  // Inside, on faces, edges and corners; and what stands for nothing.
  EXPECT_LE(cpu::make_packed_body(tables, 8)->averages.runs.stencils.size(), 28u);
}

TEST(CpuRuns, ForcesAreWithinTheRoundingBound) {
  ShareOfBound shares;
  for (const Lattice& body : lattices()) {
    const auto tables = std::make_shared<const TopologyTextures>(build_topology(body.model, {}));
    const Scene scene(body.model);
    for (const double amount : {0.001, 0.2}) {
      shares.look(tables, scene, random_displacements(body.model, amount, 11), body.name, {1, 3});
    }
  }
}

}  // namespace
}  // namespace phymul::test
