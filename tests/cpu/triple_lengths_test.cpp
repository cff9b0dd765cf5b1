// SPDX-License-Identifier: MIT
//
// Attractors over all triples of neighbours: taken by the lengths of edges near rest, and by normals where a body is
// torn, squashed or turned inside out. Both are held to the rounding bound, which knows of neither.
#include <gtest/gtest.h>

#include "cpu/packed/packed_body.h"
#include "support/cpu_forces.h"
#include "support/failure_states.h"

namespace phymul::test {
namespace {

struct Deformation {
  const char* name;
  Mat3 gradient;
};

Mat3 stretch(double x, double y, double z) {
  return Vec3(x, y, z).asDiagonal();
}
Mat3 shear(double xy) {
  Mat3 F = Mat3::Identity();
  F(0, 1) = xy;
  return F;
}

/// Around both bounds of triple_lengths.h: edges of twice their length, triangles of a quarter of their area.
std::vector<Deformation> deformations() {
  return {{"small", shear(1e-4)},
          {"sheared 0.01", shear(0.01)},
          {"stretched 1.9", stretch(1.9, 1.0, 1.0)},
          {"stretched 2.1", stretch(1.0, 2.1, 1.0)},
          {"stretched 10", stretch(1.0, 1.0, 10.0)},
          {"grown 1.9", stretch(1.9, 1.9, 1.9)},
          {"grown 3", stretch(3.0, 3.0, 3.0)},
          {"sheared 1", shear(1.0)},
          {"sheared 3", shear(3.0)},
          {"squashed to 0.3", stretch(0.3, 1.0, 1.0)},
          {"squashed to 0.1", stretch(1.0, 0.1, 1.0)},
          {"shrunk to 0.6", stretch(0.6, 0.6, 0.6)},
          {"shrunk to 0.2", stretch(0.2, 0.2, 0.2)},
          {"flat", stretch(1.0, 1.0, 0.0)},
          {"mirrored", stretch(-1.0, 1.0, 1.0)}};
}

/// Lattices, whose slices share constants, and bodies of which no two particles see the same.
std::vector<Body> enumerable_bodies() {
  Model shaken = make_block({0.03, 0.03, 0.03}, 3, 3, 3, 14);
  std::mt19937 bits(5);
  shake(shaken.rest, 0.002, bits);
  Model in_line = make_block({0.03, 0.03, 0.03}, 3, 3, 3, 14);  // all but in line, many triples of neighbours
  shake(in_line.rest, 1e-6, bits);
  return {{"in line", in_line},
          {"6 neighbours", make_block({0.04, 0.03, 0.03}, 4, 3, 3, 6)},
          {"14 neighbours", make_block({0.03, 0.03, 0.03}, 3, 3, 3, 14)},
          {"uneven", shaken},
          {"tetrahedra", make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 7)},
          {"cylinder", cylinder_275()}};
}

TEST(TripleLengths, FarFromRestForcesAreWithinTheRoundingBound) {
  ShareOfBound shares;
  for (const Body& body : enumerable_bodies()) {
    for (const Reaction reaction : {Reaction::shared, Reaction::averaged}) {
      const auto tables = std::make_shared<const TopologyTextures>(
          build_topology(body.model, {.reaction = reaction, .bases = BaseSelection::all}));
      const Scene scene(body.model);
      for (const auto& [name, gradient] : deformations()) {
        VecList u = random_displacements(body.model, 0.1 * (gradient - Mat3::Identity()).norm(), 3);
        for (std::size_t i = 0; i < u.size(); ++i) {
          u[i] += gradient * tables->rest[i] - tables->rest[i];
          u[i] = u[i].cast<float>().cast<double>();
        }
        shares.look(tables, scene, u, body.name + ", " + name);
      }
    }
  }
  shares.expect_some();
}

/// What a lattice's particles see is the same but at its faces, wherever it lies.
TEST(TripleLengths, ParticlesThatSeeTheSameShareConstants) {
  const auto bytes_a_particle = [](const Model& model) {
    const TopologyTextures tables = build_topology(model, {.reaction = Reaction::shared, .bases = BaseSelection::all});
    return cpu::make_packed_body(tables, 8)->bytes_a_step() / model.particle_count();
  };
  Model lattice = make_block({0.15, 0.15, 0.15}, 15, 15, 15, 14);
  const double shared = bytes_a_particle(lattice);
  for (Vec3& p : lattice.rest) p += Vec3(0.3, -0.2, 0.1);
  EXPECT_NEAR(bytes_a_particle(lattice), shared, 0.05 * shared);
  std::mt19937 bits(5);
  shake(lattice.rest, 1e-4, bits);
  EXPECT_LT(shared, 0.6 * bytes_a_particle(lattice));
}

}  // namespace
}  // namespace phymul::test
